"""Labels on a map, placed so that they do not cover other text."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from pathgene.host.report.style import halo


__all__ = ["AWAY_INCHES", "label"]

#: Distances in inches from the place to the text, in the order tried.
AWAY_INCHES = (0.14, 0.3, 0.55)
# Directions tried at each distance.
_DIRECTIONS = 12
_PAD = 3.0


def label(
    axes: Axes,
    places: Sequence[tuple[float, float]],
    text: str,
    taken: Sequence[Bbox],
    *,
    lines: NDArray[np.float64] | None = None,
    first: float = 0.0,
    away_inches: Sequence[float] = AWAY_INCHES,
    **style: Any,
) -> Bbox | None:
    """Write ``text`` near one of several places of ``axes`` and return its box in pixels.

    If every position would cover one of ``taken`` or leave the axes, nothing is written and None is
    returned.

    Parameters
    ----------
    axes : Axes
        The axes, with fixed limits.
    places : sequence of (float, float)
        The places in units of the axes, best first; a nearby position at any of them is better than
        a distant one at the first.
    taken : sequence of Bbox
        Boxes in pixels that the text must not cover.
    lines : ndarray, optional
        Points of lines, (k, 2) in units of the axes, that the text covers only if there is no other
        room.
    first : float
        Direction that is tried first, radians anticlockwise from the right.
    away_inches : sequence of float
        Distances from a place to the text, in the order tried.
    **style
        Style of the text.
    """
    note = axes.annotate(
        text,
        places[0],
        xytext=(0, 0),
        textcoords="offset pixels",
        ha="center",
        va="center",
        path_effects=halo(1.2),
        **style,
    )
    size = note.get_window_extent()
    window = axes.get_window_extent()
    seen = np.empty((0, 2)) if lines is None else axes.transData.transform(lines)
    covering = None
    for away, place, step in itertools.product(away_inches, places, range(_DIRECTIONS)):
        angle = first + 2 * math.pi * step / _DIRECTIONS
        reach = away * axes.figure.dpi
        east = math.cos(angle) * (reach + 0.5 * size.width)
        north = math.sin(angle) * (reach + 0.5 * size.height)
        x, y = axes.transData.transform(place)
        low = x + east - 0.5 * size.width, y + north - 0.5 * size.height
        box = Bbox.from_bounds(*low, size.width, size.height).padded(_PAD)
        inside = (
            window.x0 <= box.x0
            and box.x1 <= window.x1
            and window.y0 <= box.y0
            and box.y1 <= window.y1
        )
        if not inside or any(box.overlaps(other) for other in taken):
            continue
        found = place, (east, north), box
        if not ((box.min <= seen) & (seen <= box.max)).all(axis=1).any():
            break
        covering = covering or found
    else:
        if covering is None:
            note.remove()
            return None
        found = covering
    note.xy, offset, box = found
    note.set_position(offset)
    return box
