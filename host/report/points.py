"""Marks of the points that a path must visit: start, via points and goal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from pathgene.host.report.style import GOAL, START, TEXT


if TYPE_CHECKING:
    from pathgene.host.problem.ends import Point
    from pathgene.host.problem.problem import Problem

__all__ = ["between", "draw", "draw_along", "legend"]

_START: dict[str, Any] = {"marker": "o", "color": START}
_VIA: dict[str, Any] = {"marker": "D", "color": START}
_GOAL: dict[str, Any] = {"marker": "*", "color": GOAL}
_RIM: dict[str, Any] = {"linestyle": "", "markeredgecolor": TEXT}


def between(way: Sequence[Point]) -> list[tuple[str, Point]]:
    """Return the points between the ends of a mission, each with its name.

    In a mission that ends at its start, the last point before the end is the goal.
    """
    inner = list(way[1:-1])
    names = ["via point"] * len(inner)
    if inner and way[0] == way[-1]:
        names[-1] = "goal"
    return list(zip(names, inner, strict=True))


def draw(axes: Axes, path: NDArray[np.float64], problem: Problem, unit_m: float) -> None:
    """Mark the ends of ``path``, (n, 3) float64 metres, and the points between them on a map."""
    marks = [
        (_VIA if name == "via point" else _GOAL, point) for name, point in between(problem.way)
    ]
    ends = [(_START, path[0])]
    if all(style is not _GOAL for style, _ in marks):
        ends.append((_GOAL, path[-1]))
    for style, (x, y, _) in (*ends, *marks):
        size = {"o": 11, "D": 8, "*": 19}[style["marker"]]
        axes.plot(
            x / unit_m, y / unit_m, markersize=size, markeredgewidth=1.2, zorder=9, **style, **_RIM
        )


def draw_along(axes: Axes, name: str, x: float, z: float) -> None:
    """Mark one of the points of :func:`between` on a profile, in the units of its axes."""
    style, size = (_VIA, 7) if name == "via point" else (_GOAL, 14)
    axes.plot(x, z, markersize=size, markeredgewidth=1.0, zorder=6.5, **style, **_RIM)


def legend(problem: Problem) -> list[Line2D]:
    """Return the entries of a legend: the start, via points if there are any, the goal."""
    names = [name for name, _ in between(problem.way)]
    entries = [(_START, 9, "start and end" if "goal" in names else "start")]
    if "via point" in names:
        entries.append((_VIA, 8, "via point"))
    entries.append((_GOAL, 14, "goal"))
    return [
        Line2D([], [], markersize=size, markeredgewidth=1, label=label, **style, **_RIM)
        for style, size, label in entries
    ]
