"""The convergence of a run: best and mean fitness over the generations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from pathgene.host.report.style import BEST, LEGEND, MEAN, TEXT, finish


__all__ = ["draw"]

_MOST_NAMED = 4  # Maximum number of legs whose fitness is written.


def draw(
    axes: Axes,
    history: Sequence[Sequence[float]],
    chosen: float,
    legs: Sequence[tuple[int, float]] = (),
) -> None:
    """Best and mean fitness over the generations, with the border of feasibility.

    There is at least one generation. ``chosen`` is below the best fitness if the best path is not
    feasible between the samples. The ``legs`` of a mission, each with its first row and the fitness
    of its path, are separate searches, so their lines are not joined.
    """
    axes.axhline(
        1, color=TEXT, linewidth=1, linestyle=(0, (4, 3)), zorder=2, label="feasible above 1"
    )
    rows = np.array(history, dtype=np.float64)
    for number, leg in enumerate(np.split(rows, [first for first, _ in legs[1:]])):
        _lines(axes, leg, named=number == 0)
        if number:
            axes.axvline(leg[0, 0], color=TEXT, linewidth=0.7, linestyle=":", zorder=1)
    last = max(1.0, float(rows[-1, 0]))
    axes.set_xlim(0, last)
    axes.set_ylim(0, max(1.25, 1.12 * float(rows[:, 1].max())))
    # The curves of a mission's legs rise and fall; their figures are placed above all of them.
    axes.text(
        0.985 * last,
        float(rows[:, 1].max() if legs else rows[-1, 1]) + 0.03,
        _figures(float(rows[-1, 1]), chosen, [fitness for _, fitness in legs]),
        color=BEST,
        fontsize=10,
        weight="bold",
        ha="right",
        va="bottom",
    )
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(ncols=3, **LEGEND)
    finish(axes, "Convergence", f"generation{', leg by leg' if legs else ''}", "fitness")


def _lines(axes: Axes, rows: NDArray[np.float64], *, named: bool) -> None:
    """Draw the two lines of a search, with points if not every generation has a row.

    Between two points the mean is unknown, and the best fitness is constant.
    """
    generation, best, mean = rows.T
    is_whole = 1 < len(rows) > generation[-1] - generation[0]
    style: dict[str, Any] = {}
    if not is_whole:
        # The last point is on the edge.
        style = {"marker": "o", "markersize": 4, "clip_on": False}
    axes.plot(
        generation,
        mean,
        color=MEAN,
        linewidth=1.1,
        zorder=3,
        label="mean" if named else None,
        **({"linestyle": "none"} | style if style else {}),
    )
    axes.plot(
        generation,
        best,
        color=BEST,
        linewidth=2.2,
        zorder=4,
        drawstyle="steps-post",
        label="best" if named else None,
        **style,
    )


def _figures(best: float, chosen: float, legs: Sequence[float]) -> str:
    """Return the best fitness and the fitness of the path, or of each leg if there are few legs."""
    if legs:
        found = ", ".join(f"{fitness:.4f}" for fitness in legs)
        return f"chosen {found}" if len(legs) <= _MOST_NAMED else ""
    text = f"best {best:.4f}"
    return text if f"best {chosen:.4f}" == text else f"{text}, chosen {chosen:.4f}"
