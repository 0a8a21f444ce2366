"""Detours: alternative beginnings and ends of a path that breaks a limit near its start or goal.

A planner that draws waypoints seldom finds the two or three that lead around an obstacle right
ahead of an aircraft, or turn it back. There are few routes from an end: a fixed set of polylines,
each joined to each of the next waypoints.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from functools import cache

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.jit import compiled
from pathgene.host.problem.problem import Problem


__all__ = ["detours", "load_ways"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: Waypoints of the path, counted from the end and including the last, that a detour may lead to.
_JOINS = 6
_MOST_WAYPOINTS = 3
# Slightly longer than a turn's tangent, to allow for rounding.
_MORE = 1.01
# In turn radii: straights after a turn at which the next begins, or the path continues.
_STRAIGHTS = 0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0
_FIRST_STRAIGHTS, _SECOND_STRAIGHTS = (0.05, 1.0, 2.0, 4.0), (0.7, 1.5, 3.0, 5.0)
# In degrees: the turn of a detour with one turn, and the first and second turns of a detour with
# two, on the same side or back.
_TURNS = 10, 20, 30, 40, 50, 60, 70, 80, 90
_FIRST_TURNS, _SECOND_TURNS = (60, 90), (-60, -30, 60, 90)
# For an end without a heading: directions of its first waypoint, and its distances in turn radii.
_DIRECTIONS = range(0, 360, 15)
_FREE_STRAIGHTS = 0.4, 0.7, 1.2, 2.0, 3.5


def detours(problem: Problem, path: Floats, *, at_goal: bool) -> tuple[Floats, Ints]:
    """Return variants of a path that leave its start, or reach its goal, on a different route.

    Headings of both ends are kept. Turns fit between their neighbours at the detour and where it
    joins the path; the caller evaluates everything else. Altitudes of the new waypoints are
    interpolated by distance between the end and the point where the detour joins.

    Parameters
    ----------
    path : (n, 3) float64, metres
        Start and goal included.

    Returns
    -------
    paths : (m, n + 3, 3) float64, metres
        Shortest first; none if the turn radius is infinite.
    lengths : (m,) int64
        Number of points of each path.
    """
    radius_m = problem.limits.turn_radius_m
    most = len(path) + _MOST_WAYPOINTS
    if not math.isfinite(radius_m):
        return np.empty((0, most, 3)), np.empty(0, dtype=np.int64)
    points = np.ascontiguousarray(path[::-1] if at_goal else path)
    heading = problem.headings[at_goal]
    if heading is None:
        (ways, counts), ahead = _free_ways(), np.array([1.0, 0.0])
    else:
        (ways, counts), ahead = _held_ways(), np.array(heading) * (-1 if at_goal else 1)
    aside = np.array([-ahead[1], ahead[0]])
    placed = points[0, :2] + radius_m * (ways[..., :1] * ahead + ways[..., 1:] * aside)
    # A heading at the opposite end fixes the last segment.
    joins = len(points) - (1 if problem.headings[not at_goal] is None else 2)
    metres = np.empty((len(ways), min(_JOINS, joins)))
    _measure(placed, counts, points, radius_m, metres)
    order = np.argsort(metres, axis=None, kind="stable")
    order = order[: np.count_nonzero(metres < math.inf)]
    paths, lengths = np.zeros((len(order), most, 3)), np.empty(len(order), dtype=np.int64)
    _write(placed, counts, points, order, metres.shape[1], at_goal, paths, lengths)
    return paths, lengths


def load_ways() -> None:
    """Compute the routes, which are the same for all problems."""
    _held_ways()
    _free_ways()


@cache
def _held_ways() -> tuple[Floats, Ints]:
    """Return the routes from an end with a heading; see :func:`_packed`."""
    return _packed(_from_heading())


@cache
def _free_ways() -> tuple[Floats, Ints]:
    """Return the routes from an end without a heading; see :func:`_packed`."""
    return _packed(
        [_turned(way, math.radians(degrees)) for degrees in _DIRECTIONS for way in _from_rest()]
    )


def _packed(ways: list[list[complex]]) -> tuple[Floats, Ints]:
    """Return routes as waypoints (m, 3, 2), in turn radii ahead and left, and their counts (m,)."""
    packed = np.zeros((len(ways), _MOST_WAYPOINTS, 2))
    for row, way in zip(packed, ways, strict=True):
        row[: len(way)] = [(point.real, point.imag) for point in way]
    return packed, np.array([len(way) for way in ways], dtype=np.int64)


def _from_heading() -> list[list[complex]]:
    """Return routes with one or two turns after a straight line; the imaginary part is left."""
    ways = []
    for degrees, straight in itertools.product(_TURNS, _STRAIGHTS):
        tangent = _tangent(degrees)
        first = complex(tangent)
        way = [first]
        if straight:
            way.append(first + _ahead(degrees, tangent + straight))
        ways.append(way)
    for first_turn, second_turn in itertools.product(_FIRST_TURNS, _SECOND_TURNS):
        for one, other in itertools.product(_FIRST_STRAIGHTS, _SECOND_STRAIGHTS):
            tangents = _tangent(first_turn), _tangent(second_turn)
            first = complex(tangents[0])
            second = first + _ahead(first_turn, sum(tangents) + one)
            third = second + _ahead(first_turn + second_turn, tangents[1] + other)
            ways.append([first, second, third])
    # A single waypoint lies ahead.
    return [side for way in ways for side in (way, _mirrored(way))[: len(way)]]


def _from_rest() -> Iterator[list[complex]]:
    """Yield routes with at most one turn after a straight line ahead, for all directions."""
    for straight in _FREE_STRAIGHTS:
        first = complex(straight)
        yield [first]
        for degrees, other in itertools.product((60, 90), (1.0, 2.5)):
            if straight >= _tangent(degrees):
                way = [first, first + _ahead(degrees, _tangent(degrees) + other)]
                yield from (way, _mirrored(way))


def _tangent(degrees: float) -> float:
    """Return the room that a turn needs on both sides of its waypoint, in turn radii."""
    return _MORE * math.tan(math.radians(abs(degrees)) / 2)


def _ahead(degrees: float, radii: float) -> complex:
    return radii * complex(math.cos(math.radians(degrees)), math.sin(math.radians(degrees)))


def _mirrored(way: list[complex]) -> list[complex]:
    return [point.conjugate() for point in way]


def _turned(way: list[complex], angle: float) -> list[complex]:
    return [point * complex(math.cos(angle), math.sin(angle)) for point in way]


@compiled
def _measure(ways: Floats, counts: Ints, points: Floats, radius_m: float, metres: Floats) -> None:
    """Write to ``metres[w, j]`` the length on route w to ``points[1 + j]`` and on to the end.

    It is infinite if a turn up to the point after the join does not fit.
    """
    n = len(points)
    for join in range(metres.shape[1]):
        behind = 0.0
        for i in range(join + 1, n - 1):
            behind += math.hypot(points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1])
        for way in range(len(ways)):
            count = counts[way]
            # Up to two points after the join: their turns depend on the detour, or limit it.
            last = min(count + 3, count + n - join - 1)
            total, run, tangent, fits = behind, 0.0, 0.0, True
            x, y = points[0, 0], points[0, 1]
            ux, uy = 0.0, 0.0
            for i in range(1, last + 1):
                if i <= count:
                    px, py = ways[way, i - 1, 0], ways[way, i - 1, 1]
                else:
                    px, py = points[join + i - count, 0], points[join + i - count, 1]
                dx, dy = px - x, py - y
                length = math.hypot(dx, dy)
                if not length > 0.0:
                    fits = False
                    break
                dx, dy = dx / length, dy / length
                here = 0.0
                if i > 1:
                    angle = math.atan2(abs(ux * dy - uy * dx), ux * dx + uy * dy)
                    here = radius_m * math.tan(0.5 * angle)
                    if tangent + here > run:
                        fits = False
                        break
                if i <= count + 1:
                    total += length
                x, y, ux, uy, run, tangent = px, py, dx, dy, length, here
            metres[way, join] = total if fits and tangent <= run else math.inf


@compiled
def _write(
    ways: Floats,
    counts: Ints,
    points: Floats,
    order: Ints,
    joins: int,
    is_backwards: bool,
    paths: Floats,
    lengths: Ints,
) -> None:
    """Write the paths numbered ``order``: route times ``joins`` plus join."""
    n = len(points)
    for row in range(len(order)):
        way, join = order[row] // joins, order[row] % joins
        count = counts[way]
        size = count + n - join
        lengths[row] = size
        run = 0.0
        for i in range(size):
            at = size - 1 - i if is_backwards else i
            if i == 0 or i > count:
                source = 0 if i == 0 else join + i - count
                for axis in range(3):
                    paths[row, at, axis] = points[source, axis]
            else:
                paths[row, at, 0] = ways[way, i - 1, 0]
                paths[row, at, 1] = ways[way, i - 1, 1]
            # Until the altitudes of the detour are known, this column holds the distance flown.
            if 0 < i <= count + 1:
                before = at + 1 if is_backwards else at - 1
                run += math.hypot(
                    paths[row, at, 0] - paths[row, before, 0],
                    paths[row, at, 1] - paths[row, before, 1],
                )
                if i <= count:
                    paths[row, at, 2] = run
        first, rise = points[0, 2], points[join + 1, 2] - points[0, 2]
        for i in range(1, count + 1):
            at = size - 1 - i if is_backwards else i
            paths[row, at, 2] = first + rise * paths[row, at, 2] / run
