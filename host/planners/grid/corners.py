"""Corners of a route of many points, as candidates for waypoints."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


__all__ = ["cornered"]

Floats = NDArray[np.float64]

# Points of a route that may become waypoints.
_MOST_CORNERS = 300


def cornered(route: Floats, least_m: float) -> Floats:
    """Return corners of a route, up to 300 points, and points between them, with both ends.

    A polyline through the corners keeps within a distance of the route, which grows until there are
    few enough. Half of them lie between corners that are far apart.
    """
    most = _MOST_CORNERS // 2
    kept = _simplified(route, least_m)
    while len(kept) > most:
        least_m *= 1.5
        kept = _simplified(route, least_m)
    # Points of the route between the corners, where the gap between two of them is longest.
    indices = kept.tolist()
    while len(indices) < min(_MOST_CORNERS, len(route)):
        gaps = np.diff(indices)
        widest = int(gaps.argmax())
        if gaps[widest] < 2:
            break
        indices.insert(widest + 1, indices[widest] + int(gaps[widest]) // 2)
    points: Floats = route[indices]
    moved = (np.diff(points, axis=0) != 0).any(axis=1)
    distinct: Floats = points[np.append(True, moved)]
    return distinct


def _simplified(route: Floats, within_m: float) -> NDArray[np.int64]:
    """Return the indices of the points that Douglas and Peucker keep."""
    kept, open_spans = {0, len(route) - 1}, [(0, len(route) - 1)]
    while open_spans:
        first, last = open_spans.pop()
        if last - first < 2:
            continue
        chord = route[last] - route[first]
        offset = route[first + 1 : last] - route[first]
        length = math.hypot(*chord)
        if length > 0:
            away = np.abs(offset[:, 0] * chord[1] - offset[:, 1] * chord[0]) / length
        else:
            away = np.hypot(*offset.T)
        middle = int(away.argmax())
        if away[middle] > within_m:
            middle += first + 1
            kept.add(middle)
            open_spans += [(first, middle), (middle, last)]
    return np.array(sorted(kept))
