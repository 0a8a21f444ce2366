"""Statistics of runs over many seeds: of one planner, and of the difference between two."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats


__all__ = ["compare_two", "describe"]

Floats = NDArray[np.float64]

# A smaller relative difference is rounding.
_ROUNDING = 1e-12


def describe(records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return statistics of one planner's runs; a statistic is None if there are too few runs.

    Parameters
    ----------
    records : sequence of dict
        Runs as :func:`pathgene.host.report.summary.describe_run` gives them. F of every run counts,
        feasible or not; ``feasible`` refers to the strict rule.

    Returns
    -------
    dict
        ``runs``; ``fitness`` and ``seconds`` with ``mean``, ``std`` (of the sample, n - 1),
        ``best``, ``median`` and ``quartiles``; ``feasible`` (a number of runs), ``feasible_share``;
        ``evaluations`` and ``generations``, the means.
    """
    count = len(records)
    feasible = sum(record["feasible"] for record in records)
    return {
        "runs": count,
        "fitness": _spread([record["fitness"] for record in records], best=max),
        "seconds": _spread([record["seconds"]["total"] for record in records], best=min),
        "feasible": feasible,
        "feasible_share": feasible / count if count else None,
        "evaluations": _mean([record["evaluations"] for record in records]),
        "generations": _mean([record["generations"] for record in records]),
    }


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _spread(values: Sequence[float], best: Any) -> dict[str, Any]:
    if not values:
        return dict.fromkeys(("mean", "std", "best", "median", "quartiles"))
    low, median, high = np.quantile(values, (0.25, 0.5, 0.75)).tolist()
    return {
        "mean": _mean(values),
        "std": float(np.std(values, ddof=1)) if len(values) > 1 else None,
        "best": best(values),
        "median": median,
        "quartiles": [low, high],
    }


def compare_two(one: Sequence[float], other: Sequence[float]) -> dict[str, Any]:
    """Return two-sided tests of the difference between two samples of F of independent runs.

    Welch's t-test compares means without assuming equal variances; the Mann-Whitney U test compares
    ranks, with its correction for ties.

    Returns
    -------
    dict
        ``mean_difference``, first minus second; ``welch`` and ``mann_whitney`` with ``statistic``
        and ``p``, both None if the test does not apply, and ``note``, which then gives the reason;
        ``superiority``, the probability that a run of the first is better than one of the second,
        counting a tie as half (Vargha and Delaney's A).
    """
    a, b = np.asarray(one, dtype=np.float64), np.asarray(other, dtype=np.float64)
    if not (len(a) and len(b)):
        none = _untested("there are no runs")
        return {"mean_difference": None, "welch": none, "mann_whitney": none, "superiority": None}
    greater = float((a[:, None] > b[None, :]).mean() + 0.5 * (a[:, None] == b[None, :]).mean())
    return {
        "mean_difference": float(a.mean() - b.mean()),
        "welch": _welch(a, b),
        "mann_whitney": _mann_whitney(a, b),
        "superiority": greater,
    }


def _welch(a: Floats, b: Floats) -> dict[str, Any]:
    refusal = _refusal(a, b)
    if refusal is None and _is_constant(a) and _is_constant(b):
        refusal = "no spread in either"
    if refusal is not None:
        return _untested(refusal)
    # Computed from the moments: given samples, SciPy warns about one without spread, which is fine
    # here.
    moments = (
        moment for values in (a, b) for moment in (values.mean(), values.std(ddof=1), len(values))
    )
    return _tested(stats.ttest_ind_from_stats(*moments, equal_var=False))


def _mann_whitney(a: Floats, b: Floats) -> dict[str, Any]:
    refusal = _refusal(a, b)
    if refusal is not None:
        return _untested(refusal)
    return _tested(stats.mannwhitneyu(a, b, alternative="two-sided"))


def _refusal(a: Floats, b: Floats) -> str | None:
    """Return the reason why no test applies to the samples, if any."""
    if min(len(a), len(b)) < 2:
        return "fewer than two runs"
    if _is_constant(np.concatenate((a, b))):
        return "no difference"
    return None


def _is_constant(values: Floats) -> bool:
    return float(np.ptp(values)) <= _ROUNDING * float(np.abs(values).max())


def _tested(result: Any) -> dict[str, Any]:
    return {"statistic": float(result.statistic), "p": float(result.pvalue), "note": None}


def _untested(note: str) -> dict[str, Any]:
    return {"statistic": None, "p": None, "note": note}
