"""Waypoints at least a second of flight apart, so that none is passed before it is the next one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from pathgene.host.mission.autopilot.route import MOST_ACCEPTANCE_M, RoutePoint
from pathgene.host.mission.autopilot.timing import Timed


__all__ = ["accepted", "spaced"]

# Acceptance radius below which a real autopilot may miss a waypoint.
_LEAST_ACCEPTANCE_M = 10
# A waypoint whose removal moves the legs sideways and up or down by less than this, metres, is left
# out, such as the tangent points of an arc between its corners.
_NO_CHANGE_M, _NO_RISE_M = 0.05, 1.0


def spaced(points: Sequence[Timed], apart_m: float) -> list[Timed]:
    """Return the waypoints less those that are near another one or change nothing.

    ArduPlane looks at its waypoint ten times a second. A waypoint that it has already passed when
    it becomes the next one is flown back to, in a full circle. Start and goal stay.

    Parameters
    ----------
    apart_m : float
        Minimum horizontal distance of two waypoints, except of start and goal.
    """
    kept = list(points)
    number = 1
    while number < len(kept) - 1:
        if _changes_nothing(points, kept, number):
            kept.pop(number)
        else:
            number += 1
    while near := [
        number
        for number in range(1, len(kept) - 1)
        if min(_gap_m(kept, number - 1), _gap_m(kept, number)) < apart_m
    ]:
        kept.pop(min(near, key=lambda number: _moved_m(kept, number)))
    return kept


def accepted(points: Sequence[RoutePoint], roll_m: float = 0.0) -> list[RoutePoint]:
    """Return the waypoints with acceptance radii of 10 m or more, less than to any neighbour.

    Parameters
    ----------
    roll_m : float
        Way that the aircraft flies while it begins to bank, by which turns begin earlier.
    """
    legs = [math.inf, *(_across_m(*pair) for pair in pairwise(points)), math.inf]
    made = []
    for point, before_m, after_m in zip(points, legs, legs[1:], strict=False):
        near_m = min(before_m, after_m, MOST_ACCEPTANCE_M + 1.0)
        wanted = _LEAST_ACCEPTANCE_M
        if point.acceptance_m > _LEAST_ACCEPTANCE_M:
            wanted = math.floor(point.acceptance_m + roll_m)
        made.append(replace(point, acceptance_m=max(1, min(wanted, math.ceil(near_m) - 1))))
    return made


def _moved_m(points: Sequence[Timed], number: int) -> float:
    """Return by how far the legs move sideways if a waypoint is left out."""
    before, point, after = (each.point for each in points[number - 1 : number + 2])
    east, north = after.x_m - before.x_m, after.y_m - before.y_m
    dx, dy = point.x_m - before.x_m, point.y_m - before.y_m
    square = east**2 + north**2
    share = min(max((dx * east + dy * north) / square, 0.0), 1.0) if square else 0.0
    return math.hypot(dx - share * east, dy - share * north)


def _changes_nothing(points: Sequence[Timed], kept: Sequence[Timed], number: int) -> bool:
    """Return whether the legs stay in place, and at the heights of all points, without one."""
    before, after = kept[number - 1], kept[number + 1]
    if _moved_m(kept, number) >= _NO_CHANGE_M:
        return False
    return all(
        abs(each.point.z_m - _height_m(before, after, each.t_s)) < _NO_RISE_M
        for each in points
        if before.t_s < each.t_s < after.t_s
    )


def _height_m(before: Timed, after: Timed, t_s: float) -> float:
    """Return the height of a leg at an instant."""
    share = (t_s - before.t_s) / (after.t_s - before.t_s) if after.t_s > before.t_s else 1.0
    return before.point.z_m + share * (after.point.z_m - before.point.z_m)


def _gap_m(points: Sequence[Timed], number: int) -> float:
    return _across_m(points[number].point, points[number + 1].point)


def _across_m(a: RoutePoint, b: RoutePoint) -> float:
    return math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)
