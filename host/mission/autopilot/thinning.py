"""Missions of few waypoints: legs that replace several, close to them and never below them."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pathgene.host.mission.autopilot.timing import Timed


__all__ = ["thinned"]

Floats = NDArray[np.float64]

# Heights above the given ones that a waypoint may get, metres.
_RAISED_M = np.array([0.0, 1.0, 2.0, 4.0, 7.0, 10.0])
# Maximum number of legs that one leg replaces.
_MOST_LEGS = 60
# Vertical speeds and heights that differ by less are equal.
_SAME = 1e-6


def thinned(
    points: Sequence[Timed],
    tolerance_m: float,
    climb_m_s: float,
    pinned: Collection[int] = (),
) -> list[Timed]:
    """Return the fewest waypoints whose legs stay close to the given legs.

    The new legs are nowhere below the given ones and at most 10 m above them, and climb and sink no
    faster than the given legs that they replace. Start and goal stay.

    Parameters
    ----------
    points : sequence of Timed
        Waypoints.
    tolerance_m : float
        Maximum horizontal distance of a waypoint that is left out from its new leg.
    climb_m_s : float
        Vertical speed that every leg may climb at.
    pinned : collection of int
        Numbers of waypoints that are not left out.
    """
    place = np.array([(each.point.x_m, each.point.y_m) for each in points])
    z = np.array([each.point.z_m for each in points])
    t = np.array([each.t_s for each in points])
    count, levels = len(points), len(_RAISED_M)
    rates = np.diff(z) / np.maximum(np.diff(t), _SAME)
    # Legs and height gained up to a waypoint at a level, and the waypoint and level before it.
    best = np.full((count, levels, 2), math.inf)
    origin = np.zeros((count, levels, 2), np.intp)
    best[0, 0] = 0.0
    for first in range(count - 1):
        start = best[first]
        if not np.isfinite(start).any():
            continue
        for last in range(first + 1, min(first + _MOST_LEGS, count - 1) + 1):
            inner = slice(first + 1, last)
            if last > first + 1:
                if last - 1 in pinned:
                    break
                if not _is_near(place[first], place[last], place[inner], tolerance_m):
                    continue
            low, high = float(rates[first:last].min()), float(rates[first:last].max())
            allowed = _allowed(t[first : last + 1], z[first : last + 1], low, max(high, climb_m_s))
            if last == count - 1:
                allowed[:, 1:] = False
            for a, b in np.argwhere(allowed).tolist():
                legs, gained = float(start[a, 0]) + 1, float(start[a, 1] + _RAISED_M[b])
                if (legs, gained) < tuple(best[last, b]):
                    best[last, b] = legs, gained
                    origin[last, b] = first, a
    number, level = count - 1, 0
    made = []
    while number:
        made.append(_raised(points[number], float(_RAISED_M[level])))
        number, level = origin[number, level].tolist()
    return [points[0], *made[::-1]]


def _is_near(start: Floats, stop: Floats, places: Floats, tolerance_m: float) -> bool:
    """Return whether places lie beside a line, in this order."""
    leg = stop - start
    square = float(leg @ leg)
    if not square:
        return False
    along = (places - start) @ leg / square
    if along[0] <= 0 or along[-1] >= 1 or (np.diff(along) <= 0).any():
        return False
    beside = (places - start) - along[:, None] * leg
    return bool((np.hypot(*beside.T) <= tolerance_m).all())


def _allowed(t: Floats, z: Floats, low_m_s: float, high_m_s: float) -> NDArray[np.bool_]:
    """Return the pairs of levels between which a leg keeps the heights and the vertical speeds."""
    start, stop = z[0] + _RAISED_M[:, None], z[-1] + _RAISED_M[None, :]
    rate = (stop - start) / max(float(t[-1] - t[0]), _SAME)
    allowed: NDArray[np.bool_] = (rate <= high_m_s + _SAME) & (rate >= min(low_m_s, 0.0) - _SAME)
    if len(t) > 2:
        share = ((t[1:-1] - t[0]) / (t[-1] - t[0]))[:, None, None]
        above = start + share * (stop - start) - z[1:-1, None, None]
        allowed &= ((above >= -_SAME) & (above <= _RAISED_M[-1] + _SAME)).all(axis=0)
    return allowed


def _raised(each: Timed, by_m: float) -> Timed:
    return replace(each, point=replace(each.point, z_m=each.point.z_m + by_m))
