"""Missions of few waypoints: legs that replace several, close to them and never below them."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pathgene.host.mission.autopilot.timing import Timed


__all__ = ["RAISED_M", "thinned"]

Floats = NDArray[np.float64]

#: Heights above the given ones that a waypoint may get, metres.
RAISED_M = (0.0, 1.0, 2.0, 4.0, 7.0, 10.0, 15.0, 20.0, 25.0, 30.0)
# Maximum number of legs that one leg replaces.
_MOST_LEGS = 60
# Vertical speeds and heights that differ by less are equal.
_SAME = 1e-6


def thinned(
    points: Sequence[Timed],
    tolerance_m: float,
    climb_m_s: float,
    pinned: Collection[int] = (),
    raised_m: Sequence[float] = RAISED_M,
) -> list[Timed]:
    """Return the fewest waypoints whose legs stay close to the given legs.

    The new legs are nowhere below the given ones and at most the last of ``raised_m`` above them,
    and climb and sink no faster than the given legs that they replace. Start and goal stay.

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
    raised_m : sequence of float
        Heights above the given ones that a waypoint may get, metres, in rising order from 0.
    """
    raised = np.array(raised_m)
    place = np.array([(each.point.x_m, each.point.y_m) for each in points])
    z = np.array([each.point.z_m for each in points])
    t = np.array([each.t_s for each in points])
    count, levels = len(points), len(raised)
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
            heights = t[first : last + 1], z[first : last + 1]
            allowed = _allowed(*heights, low, max(high, climb_m_s), raised)
            if last == count - 1:
                allowed[:, 1:] = False
            for a, b in np.argwhere(allowed).tolist():
                legs, gained = float(start[a, 0]) + 1, float(start[a, 1] + raised[b])
                if (legs, gained) < tuple(best[last, b]):
                    best[last, b] = legs, gained
                    origin[last, b] = first, a
    number, level = count - 1, 0
    made = []
    while number:
        made.append(_raised(points[number], float(raised[level])))
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


def _allowed(
    t: Floats, z: Floats, low_m_s: float, high_m_s: float, raised: Floats
) -> NDArray[np.bool_]:
    """Return the pairs of levels between which a leg keeps the heights and the vertical speeds."""
    start, stop = z[0] + raised[:, None], z[-1] + raised[None, :]
    rate = (stop - start) / max(float(t[-1] - t[0]), _SAME)
    allowed: NDArray[np.bool_] = (rate <= high_m_s + _SAME) & (rate >= min(low_m_s, 0.0) - _SAME)
    if len(t) > 2:
        share = ((t[1:-1] - t[0]) / (t[-1] - t[0]))[:, None, None]
        above = start + share * (stop - start) - z[1:-1, None, None]
        allowed &= ((above >= -_SAME) & (above <= raised[-1] + _SAME)).all(axis=0)
    return allowed


def _raised(each: Timed, by_m: float) -> Timed:
    return replace(each, point=replace(each.point, z_m=each.point.z_m + by_m))
