"""Reduction of a route of many points to a path of few waypoints, in plan view."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Straight
from pathgene.host.evaluation.geometry import smooth
from pathgene.host.evaluation.jit import compiled
from pathgene.host.planners.grid.grid_search import Place, SearchGrid
from pathgene.host.problem.problem import Problem


__all__ = [
    "Leads",
    "around",
    "between",
    "leads",
    "lengthened",
    "on_corners",
    "polylines",
    "routed",
    "sloped",
    "thinned",
    "with_leads",
]


Floats = NDArray[np.float64]

# Maximum number of points of a route that may become waypoints: every pair is evaluated.
_MOST_POINTS = 100
# Slope of the surfaces for an aircraft that can hardly climb.
_LEAST_SLOPE = 1e-3


def thinned(route: Floats, corner_m: tuple[float, float] | None = None) -> Floats:
    """Return up to 100 evenly spaced points of ``route``, (n, 2) float64 metres, with both ends.

    With ``corner_m``, inner points move to its nearest multiples, and duplicates are removed.
    """
    every = math.ceil(len(route) / _MOST_POINTS)
    between = route[every:-1:every]
    if corner_m is not None:
        between = on_corners(between, corner_m)
    points: Floats = np.concatenate((route[:1], between, route[-1:]))
    moved = (np.diff(points, axis=0) != 0).any(axis=1)
    distinct: Floats = points[np.append(True, moved)]
    return distinct


def on_corners(places: Floats, corner_m: tuple[float, float]) -> Floats:
    """Return the multiples of ``corner_m`` nearest to ``places``, (n, 2) float64 metres."""
    nearest: Floats = np.floor(places / corner_m + 0.5) * corner_m
    return nearest


def polylines(
    points: Floats, grid: SearchGrid, surface: Floats, most: int
) -> list[NDArray[np.intp] | None]:
    """Return the cheapest polyline through ``points`` for each number of waypoints, 0 to ``most``.

    Each is the shortest path with that number of chords through the graph of all chords. The cost
    of a chord is the cost of level flight on ``surface``. Chords are long enough for two turns of a
    right angle; chords from the start and to the goal, for one.

    Parameters
    ----------
    points : (n, 2) float64, metres
        Points of a route, start and goal included.

    Returns
    -------
    list of ndarray or None
        Indices into ``points`` of each polyline, ends included; None where no polyline was found.
    """
    chords = _chord_costs(points, grid, surface)
    before: list[NDArray[np.intp]] = []
    best = chords[0]
    found = [_walk(before, best)]
    for _ in range(most):
        through = best[:, None] + chords
        before.append(through.argmin(axis=0))
        best = through.min(axis=0)
        found.append(_walk(before, best))
    return found


def lengthened(path: Floats, fewest: int, radius_m: float) -> Floats:
    """Return a path with at least ``fewest`` waypoints between its ends, on the same track.

    The new waypoints divide the straight pieces of the smoothed path into equal parts, the longest
    part as short as possible. There they neither turn the path nor interfere with a turn; a path
    without straight pieces gets no new waypoint.

    Parameters
    ----------
    path : (n, 2) or (n, 3) float64, metres
        Places or points, start and goal included.
    """
    more = fewest - (len(path) - 2)
    if more <= 0:
        return path
    # The altitudes are the indices of the waypoints, so they give the places of the pieces.
    numbers = np.arange(len(path), dtype=np.float64)
    pieces = smooth(np.column_stack((path[:, :2], numbers)), radius_m).pieces
    straights = [piece for piece in pieces if isinstance(piece, Straight)]
    if not straights:
        return path
    # Lengths of the parts of each piece, the longest first, and their numbers.
    parts = [(-piece.run_m, which, 1) for which, piece in enumerate(straights)]
    heapq.heapify(parts)
    for _ in range(more):
        _, which, count = parts[0]
        heapq.heapreplace(parts, (-straights[which].run_m / (count + 1), which, count + 1))
    at = np.concatenate(
        [
            straights[which].start[2] + straights[which].rise_m * np.arange(1, count) / count
            for _, which, count in sorted(parts, key=lambda part: part[1])
        ]
    )
    before = np.minimum(at.astype(np.int64), len(path) - 2)
    share = (at - before)[:, None]
    added = (1 - share) * path[before] + share * path[before + 1]
    longer: Floats = np.insert(path, before + 1, added, axis=0)
    return longer


def _walk(before: list[NDArray[np.intp]], best: Floats) -> NDArray[np.intp] | None:
    """Return the polyline that reaches the goal at cost ``best[-1]``, from its end to its start."""
    if not math.isfinite(best[-1]):
        return None
    nodes = [len(best) - 1]
    for last in reversed(before):
        nodes.append(int(last[nodes[-1]]))
    return np.array([0, *reversed(nodes)])


def _chord_costs(points: Floats, grid: SearchGrid, surface: Floats) -> Floats:
    """Return the cost of a straight flight from each point to each later one: (n, n)."""
    count = len(points)
    one, other = np.triu_indices(count, 1)
    run = np.hypot(*(points[other] - points[one]).T)
    # An even number, so that no sample of a route's step lies at the corner of four nodes.
    parts = 2 * np.maximum(np.ceil(run / min(grid.dx_m, grid.dy_m)), 1).astype(np.int64)
    first = np.concatenate(([0], np.cumsum(parts)[:-1]))
    terrain = grid.problem.terrain
    price = np.empty(parts.sum())
    _along(
        points,
        one,
        other,
        parts,
        grid.price_per_m(surface),
        (terrain.dx_m, terrain.dy_m),
        terrain.shape,
        grid.every,
        price,
    )
    radius_m = grid.problem.limits.turn_radius_m
    shortest = radius_m * ((one > 0).astype(np.int64) + (other < count - 1))
    costs = np.full((count, count), math.inf)
    total = np.add.reduceat(price, first) * (run / parts)
    costs[one, other] = np.where(run >= shortest, total, math.inf)
    return costs


@compiled
def _along(
    points: Floats,
    one: NDArray[np.int64],
    other: NDArray[np.int64],
    parts: NDArray[np.int64],
    prices: Floats,
    sides_m: tuple[float, float],
    shape: tuple[int, int],
    every: int,
    found: Floats,
) -> None:
    """Write the price at the middle of each part of each chord, chord after chord.

    Compiled, because an array for each step takes longer than the search for the route.

    Parameters
    ----------
    prices : (rows, columns) float64
        Prices of the nodes of the grid, each of which covers ``every`` x ``every`` cells of the
        terrain, with their sides and shape.
    """
    dx_m, dy_m = sides_m
    rows, columns = shape
    size = 0
    for chord in range(len(parts)):
        x, y = points[one[chord], 0], points[one[chord], 1]
        across, up = points[other[chord], 0] - x, points[other[chord], 1] - y
        for part in range(parts[chord]):
            share = (part + 0.5) / parts[chord]
            # The nearest node of the terrain, as Terrain.nearest_nodes finds it.
            column = math.floor((x + across * share) / dx_m + 0.5)
            row = math.floor((y + up * share) / dy_m + 0.5)
            column, row = min(max(column, 0), columns - 1), min(max(row, 0), rows - 1)
            found[size] = prices[row // every, column // every]
            size += 1


#: Waypoints after the start, and before the goal: (k, 2) float64 metres each.
Leads = tuple[Floats, Floats]

_NONE: Floats = np.empty((0, 2))
# Unit vectors to eight points of the compass.
_ANGLES = np.arange(8) * (math.pi / 4)
_COMPASS: Floats = np.stack((np.sin(_ANGLES), np.cos(_ANGLES)), axis=1)
# Turns below the first angle are made at the end itself or just ahead of it; above the second, the
# path must turn back.
_GENTLE_RAD, _BACK_RAD = math.radians(45), math.radians(100)


def leads(problem: Problem) -> Iterator[Leads]:
    """Yield routes that leave the start and reach the goal with their headings, in metres.

    Without headings there is a single lead, without waypoints. A waypoint lies a turn radius ahead
    of the start, so that a right angle fits there; if the route leads back, another one lies two
    radii to the side. The routes to the goal mirror these. A route with a waypoint off the map is
    omitted.
    """
    start, goal = np.array(problem.start[:2]), np.array(problem.goal[:2])
    after, before = problem.headings
    if not math.isfinite(problem.limits.turn_radius_m):
        after = before = None
    radius = problem.limits.turn_radius_m
    firsts = [_NONE] if after is None else list(_ways(start, np.array(after), goal, radius))
    lasts = [_NONE] if before is None else list(_ways(goal, -np.array(before), start, radius))
    for first, last in itertools.product(firsts, lasts):
        points = np.concatenate((first, last))
        most = problem.terrain.width_m, problem.terrain.height_m
        if ((points >= 0) & (points <= most)).all():
            yield first, last[::-1]


def _ways(end: Floats, heading: Floats, other: Floats, radius: float) -> Iterator[Floats]:
    """Yield the waypoints of routes that leave an end with ``heading`` and lead to ``other``."""
    line = other - end
    cross = heading[0] * line[1] - heading[1] * line[0]
    turn = math.atan2(cross, float(heading @ line))
    ahead = end + radius * heading
    aside = 2.0 * radius * np.array((-heading[1], heading[0]))
    if abs(turn) < _GENTLE_RAD:
        yield _NONE
    if abs(turn) < _BACK_RAD:
        yield ahead[None]
    if abs(turn) > _GENTLE_RAD:
        side = 1.0 if turn >= 0 else -1.0
        yield np.stack((ahead, ahead + side * aside))
        if abs(turn) > _BACK_RAD:
            yield np.stack((ahead, ahead - side * aside))


def around(problem: Problem, at_goal: bool, away_m: float) -> list[Floats]:
    """Return waypoints around the start or the goal, (1, 2) metres each, in eight directions.

    Waypoints off the map are left out; an end with a fixed heading has none.
    """
    if problem.headings[at_goal] is not None or not math.isfinite(away_m):
        return []
    end = np.array((problem.goal if at_goal else problem.start)[:2])
    most = problem.terrain.width_m, problem.terrain.height_m
    places = end + away_m * _COMPASS
    return [place[None] for place in places if ((place >= 0) & (place <= most)).all()]


def routed(grid: SearchGrid, steepness: float, way: Leads) -> tuple[Floats, Floats | None]:
    """Return a surface of limited slope, and the cheapest route over it between leads.

    Parameters
    ----------
    steepness : float
        Slope of the surface, as a multiple of the climb limit; infinite for the ground itself.

    Returns
    -------
    surface : ndarray
        Altitudes of the nodes, (rows, columns) float64 metres.
    route : ndarray or None
        Points, (n, 2) float64 metres; None if there is no route.
    """
    surface = sloped(grid, steepness)
    return surface, grid.route(surface, *between(way))


def sloped(grid: SearchGrid, steepness: float) -> Floats:
    """Return the surface of :func:`routed`."""
    climb = math.tan(grid.problem.limits.climb_rad)
    return grid.surface(steepness * max(climb, _LEAST_SLOPE))


def between(way: Leads) -> tuple[Place | None, Place | None]:
    """Return the places between which a route with leads is searched; None for start and goal."""
    first, last = (
        (float(lead[at][0]), float(lead[at][1])) if len(lead) else None
        for lead, at in zip(way, (-1, 0), strict=True)
    )
    return first, last


def with_leads(problem: Problem, way: Leads, places: Floats) -> Floats:
    """Return the places of a route with its leads and both ends, (n, 2) float64 metres.

    The ends of the route are waypoints where leads replace start and goal.
    """
    start, goal = np.array([problem.start[:2]]), np.array([problem.goal[:2]])
    before = (start, way[0][:-1]) if len(way[0]) else ()
    after = (way[1][1:], goal) if len(way[1]) else ()
    return np.concatenate((*before, places, *after))
