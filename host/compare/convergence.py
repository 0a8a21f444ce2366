"""Convergence of many runs: the bands of best F over generations or evaluations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


__all__ = ["Band", "band", "same_generations", "work_of"]

Floats = NDArray[np.float64]
Run = Mapping[str, Any]

_POINTS = 400
# Generations count as equal if their numbers of evaluations differ by at most this share.
_ALIKE = 0.01


@dataclass(frozen=True)
class Band:
    """Quartiles of the best F of several runs, (n,) each, over generations or evaluations ``x``.

    The band begins where every run has a value and ends with the longest run; a run that ended
    earlier keeps its last value.
    """

    x: Floats
    low: Floats
    median: Floats
    high: Floats


def work_of(run: Run) -> Floats:
    """Cumulative evaluations at each entry of the history of ``run``, (n,), 1 or more.

    They are spread evenly over the history if the planner did not count them.
    """
    spent = run["history_evaluations"]
    if len(spent) != len(run["history"]):
        share = np.arange(1, len(run["history"]) + 1) / len(run["history"])
        spent = share * run["evaluations"]
    return np.maximum(np.asarray(spent, dtype=np.float64), 1)


def same_generations(runs: Sequence[Run]) -> bool:
    """Return whether a generation takes as many evaluations in all ``runs``."""
    each = [np.ptp(work_of(run)) / run["generations"] for run in runs if run["generations"]]
    return len(each) == len(runs) and min(each) >= (1 - _ALIKE) * max(each)


def band(runs: Sequence[Run], *, by_generation: bool, logarithmic: bool) -> Band:
    """Return the band of one or more runs with a history.

    Parameters
    ----------
    runs : sequence
        As :func:`pathgene.host.report.summary.describe_run` gives them.
    logarithmic : bool
        Space the points evenly on a logarithmic axis.
    """
    curves = []
    for run in runs:
        history = np.array(run["history"], dtype=np.float64)
        curves.append((history[:, 0] if by_generation else work_of(run), history[:, 1]))
    first = max(float(x[0]) for x, _ in curves)
    last = max(first, *(float(x[-1]) for x, _ in curves))
    spaced = np.geomspace if logarithmic else np.linspace
    grid = np.clip(spaced(first, last, _POINTS), first, last)
    best = np.stack([y[np.searchsorted(x, grid, side="right") - 1] for x, y in curves])
    low, median, high = np.quantile(best, (0.25, 0.5, 0.75), axis=0)
    return Band(grid, low, median, high)
