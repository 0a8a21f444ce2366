"""Texts beside things on a map, where they cover no other text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import Bbox

from host.report.palette import halo


__all__ = ["label"]

# Inches from the place to the text, tried in this order, and the directions tried at each.
_AWAY_INCHES = (0.14, 0.3, 0.55)
_DIRECTIONS = 12
_PAD = 3.0


def label(
    axes: Axes, x: float, y: float, text: str, taken: Sequence[Bbox], **style: Any
) -> Bbox | None:
    """Write ``text`` near a place of ``axes`` and return its box in pixels.

    There is no text, and None, where each place would cover one of ``taken`` or leave the axes.
    """
    note = axes.annotate(
        text,
        (x, y),
        xytext=(0, 0),
        textcoords="offset pixels",
        ha="center",
        va="center",
        path_effects=halo(1.2),
        **style,
    )
    size = note.get_window_extent()
    here = axes.transData.transform((x, y))
    window = axes.get_window_extent()
    for away in _AWAY_INCHES:
        for step in range(_DIRECTIONS):
            angle = 2 * math.pi * step / _DIRECTIONS
            reach = away * axes.figure.dpi
            east = math.cos(angle) * (reach + 0.5 * size.width)
            north = math.sin(angle) * (reach + 0.5 * size.height)
            low = here + np.array((east, north)) - (0.5 * size.width, 0.5 * size.height)
            box = Bbox.from_bounds(low[0], low[1], size.width, size.height).padded(_PAD)
            inside = (
                window.x0 <= box.x0
                and box.x1 <= window.x1
                and window.y0 <= box.y0
                and box.y1 <= window.y1
            )
            if inside and not any(box.overlaps(other) for other in taken):
                note.set_position((east, north))
                return box
    note.remove()
    return None
