"""Marks of faults on a map or a profile, with their numbers in a list."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.offsetbox import AnchoredOffsetbox
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from pathgene.host.report.placing import AWAY_INCHES, label
from pathgene.host.report.style import TROUBLE, halo


__all__ = ["draw", "legend", "together"]

_DOT: dict[str, Any] = {
    "linestyle": "",
    "marker": "o",
    "markersize": 8,
    "markerfacecolor": TROUBLE,
    "markeredgecolor": "white",
    "markeredgewidth": 1.2,
}
_NUMBER: dict[str, Any] = {"color": TROUBLE, "fontsize": 11, "weight": "bold", "zorder": 13}
# Marks that are nearer to each other have one text.
_NEAR_INCHES = 0.16
# Direction from a mark to its number that is tried first.
_ABOVE = 0.5 * math.pi
# Half the side of the square around a mark that numbers leave free.
_DOT_INCHES = 0.06


def draw(axes: Axes, marks: Sequence[tuple[int, float, float]], lines: NDArray[np.float64]) -> None:
    """Mark faults, each with its number; numbers of neighbours share a text.

    Parameters
    ----------
    axes : Axes
        The axes, with fixed limits and all their other texts.
    marks : sequence of (int, float, float)
        The number and the place in units of the axes.
    lines : ndarray
        Points of lines, (k, 2) in units of the axes, that the numbers cover only if there is no
        other room.
    """
    taken = [
        each.get_window_extent()
        for each in axes.get_children()
        if isinstance(each, AnchoredOffsetbox) or (isinstance(each, Text) and each.get_text())
    ]
    for _, x, y in marks:
        axes.plot(x, y, zorder=12, clip_on=False, **_DOT)
    places = np.array([(x, y) for _, x, y in marks]).reshape(-1, 2)
    pixels = axes.transData.transform(places)
    reach = _DOT_INCHES * axes.figure.dpi
    taken += [Bbox([place - reach, place + reach]) for place in pixels]
    for group in together(pixels, _NEAR_INCHES * axes.figure.dpi):
        text = _numbers([marks[i][0] for i in group])
        place = marks[group[0]][1], marks[group[0]][2]
        # A number that covers a line is better than one far from its mark.
        for away in AWAY_INCHES:
            box = label(
                axes,
                [place],
                text,
                taken,
                lines=lines,
                first=_ABOVE,
                away_inches=(away,),
                **_NUMBER,
            )
            if box is not None:
                break
        else:
            # A number on its mark is better than none.
            note = axes.annotate(
                text, place, ha="center", va="center", path_effects=halo(1.2), **_NUMBER
            )
            box = note.get_window_extent()
        taken.append(box)


def legend() -> Line2D:
    """Return the entry of a legend."""
    return Line2D([], [], label="fault, numbered as listed", **_DOT)


def together(places: NDArray[np.float64], near: float) -> list[list[int]]:
    """Return the indices of places (k, 2) in groups: each is near the first of its group."""
    groups: list[list[int]] = []
    for i, place in enumerate(places):
        for group in groups:
            if np.hypot(*(place - places[group[0]])) <= near:
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def _numbers(numbers: Sequence[int]) -> str:
    """Return ascending numbers as text: ``1, 3-5``."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(
        f"{run[0]}-{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs
    )
