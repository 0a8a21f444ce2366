"""The convergence of a run: best and mean fitness over the generations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from host.report.axes import LEGEND, finish
from host.report.palette import BEST, MEAN, TEXT


__all__ = ["draw"]


def draw(axes: Axes, history: Sequence[Sequence[float]], chosen: float) -> None:
    """Best and mean fitness over the generations, with the border of feasibility.

    There is one generation or more. ``chosen`` is below the best where the best path is not
    feasible between the samples.
    """
    axes.axhline(
        1, color=TEXT, linewidth=1, linestyle=(0, (4, 3)), zorder=2, label="feasible above 1"
    )
    generation, best, mean = np.array(history, dtype=np.float64).T
    axes.plot(generation, mean, color=MEAN, linewidth=1.1, zorder=3, label="mean")
    axes.plot(
        generation,
        best,
        color=BEST,
        linewidth=2.2,
        zorder=4,
        drawstyle="steps-post",
        label="best",
    )
    last = max(1.0, float(generation[-1]))
    axes.set_xlim(0, last)
    axes.set_ylim(0, max(1.25, 1.12 * float(best.max())))
    text = f"best {best[-1]:.4f}"
    if f"{chosen:.4f}" != f"{best[-1]:.4f}":
        text += f", chosen {chosen:.4f}"
    axes.text(
        0.985 * last,
        float(best[-1]) + 0.03,
        text,
        color=BEST,
        fontsize=10,
        weight="bold",
        ha="right",
        va="bottom",
    )
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(ncols=3, **LEGEND)
    finish(axes, "Convergence", "generation", "fitness")
