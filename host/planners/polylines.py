"""From a route of many points to a path of few waypoints, as seen from above."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from host.evaluation import Straight
from host.evaluation.geometry import smooth
from host.planners.grid_search import SearchGrid


__all__ = ["lengthened", "on_corners", "polylines", "thinned"]

Floats = NDArray[np.float64]

# Of a route, that may become waypoints: every pair is looked at.
_MOST_POINTS = 100


def thinned(route: Floats, corner_m: tuple[float, float] | None = None) -> Floats:
    """At most 100 points of ``route``, (n, 2) float64 metres, evenly drawn, both ends included.

    With ``corner_m`` those between go to the nearest multiples of it, and none comes twice.
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
    """The nearest multiples of ``corner_m`` to ``places``, (n, 2) float64 metres."""
    nearest: Floats = np.floor(places / corner_m + 0.5) * corner_m
    return nearest


def polylines(
    points: Floats,
    grid: SearchGrid,
    surface: Floats,
    most: int,
) -> list[NDArray[np.intp] | None]:
    """For 0 to ``most`` waypoints the cheapest of all polylines through ``points``.

    A shortest path through the graph of all chords, by its number of chords: level flight on
    ``surface`` is what a chord costs. Chords are long enough for two turns of a right angle, those
    from the start and to the goal for one.

    Parameters
    ----------
    points : (n, 2) float64, metres
        Of a route, start and goal included.
    grid : SearchGrid
    surface : (rows, columns) float64, metres
    most : int

    Returns
    -------
    list of ndarray or None
        Indices into ``points`` of each polyline, ends included; None where there is none.
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
    """Give a path at least ``fewest`` waypoints between its ends, and leave its track.

    Each new one lies in the middle of the longest straight piece of the smoothed path, where it
    turns nothing and is in no turn's way; there is none if all of the path turns.

    Parameters
    ----------
    path : (n, 2) or (n, 3) float64, metres
        Places or points, start and goal included.
    fewest : int
    radius_m : float
        Turning radius.
    """
    for _ in range(fewest - (len(path) - 2)):
        numbers = np.arange(len(path), dtype=np.float64)
        pieces = smooth(np.column_stack((path[:, :2], numbers)), radius_m).pieces
        straights = [piece for piece in pieces if isinstance(piece, Straight)]
        if not straights:
            break
        longest = max(straights, key=lambda piece: piece.run_m)
        # The altitudes are the numbers of waypoints, so the middle says where it is.
        middle = longest.start[2] + longest.rise_m / 2
        before = min(int(middle), len(path) - 2)
        share = middle - before
        added = (1 - share) * path[before] + share * path[before + 1]
        path = np.insert(path, before + 1, added, axis=0)
    return path


def _walk(before: list[NDArray[np.intp]], best: Floats) -> NDArray[np.intp] | None:
    """The polyline that reaches the goal at cost ``best[-1]``, from its end to its start."""
    if not math.isfinite(best[-1]):
        return None
    nodes = [len(best) - 1]
    for last in reversed(before):
        nodes.append(int(last[nodes[-1]]))
    return np.array([0, *reversed(nodes)])


def _chord_costs(points: Floats, grid: SearchGrid, surface: Floats) -> Floats:
    """Cost of flying straight from each point to each later one: (n, n), infinite for none."""
    count = len(points)
    one, other = np.triu_indices(count, 1)
    run = np.hypot(*(points[other] - points[one]).T)
    # An even number, so that no sample of a step of the route falls on the corner of four nodes.
    parts = 2 * np.maximum(np.ceil(run / min(grid.dx_m, grid.dy_m)), 1).astype(np.int64)
    first = np.concatenate(([0], np.cumsum(parts)[:-1]))
    chord = np.repeat(np.arange(len(run)), parts)
    share = (np.arange(len(chord)) - first[chord] + 0.5) / parts[chord]
    at = points[one][chord] + (points[other] - points[one])[chord] * share[:, None]
    price = grid.price_per_m(surface)[grid.nodes(*at.T)]
    radius_m = grid.problem.aircraft.turn_radius_m
    shortest = radius_m * ((one > 0).astype(np.int64) + (other < count - 1))
    costs = np.full((count, count), math.inf)
    total = np.add.reduceat(price, first) * (run / parts)
    costs[one, other] = np.where(run >= shortest, total, math.inf)
    return costs
