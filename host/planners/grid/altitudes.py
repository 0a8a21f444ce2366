"""The lowest altitudes of waypoints at given places: a linear program."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import Arc, Straight
from pathgene.host.evaluation.evaluator import FINE
from pathgene.host.evaluation.geometry import smooth
from pathgene.host.evaluation.jit import compiled
from pathgene.host.planners.grid.grid_search import Prices
from pathgene.host.planners.grid.linear_program import minimised
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


__all__ = ["lowest_altitudes"]

Floats = NDArray[np.float64]

# Clearance over the ground in metres, so that rounding puts no sample under it.
_CLEARANCE_M = 1e-3
# Margins to the limits of slope, as tangents. The first exceeds the solver's tolerance. The second
# holds with the strict rule where the limits allow it: the path then keeps them over a map in
# another projection, too, whose lengths differ by up to 0.1 %.
_TOLERANCE = 1e-6
_SLOPE_MARGIN = 1e-4
# Price of excess slope, in metres of altitude over the whole path.
_TOO_STEEP = 1e6
# Price of a metre below the minimum, in metres of altitude over the whole path.
_TOO_LOW = 10.0
# Shorter arcs are hardly steeper than the segments that they join.
_SHORT_ARC_M = 1e-3


def lowest_altitudes(
    problem: Problem, prices: Prices, places: Floats, *, base_m: float = 0.0, step_m: float = 0.0
) -> Floats | None:
    """Return a path whose waypoints have the cheapest altitudes.

    For given places, the plan view of the smoothed path is fixed, and the altitude anywhere on it
    is linear in the altitudes of the waypoints. So are the cost of altitude, each limit of climb
    and descent (on arcs, too) and the clearance over the ground. Fuel is convex, because a glide
    that needs no thrust burns nothing, however steep. If the limits of slope cannot be kept, they
    are exceeded as little as possible.

    Parameters
    ----------
    prices : Prices
        Prices of altitude and climb.
    places : (n, 2) float64, metres
        Waypoints, start and goal included.
    base_m, step_m : float
        With a step, the altitudes of waypoints are ``base_m`` plus whole steps, rounded up; limits
        still hold.

    Returns
    -------
    ndarray or None
        The path, (n, 3) float64 metres; None if an arc does not fit between its neighbours, or
        a piece of the path is vertical.
    """
    count = len(places)
    # The altitudes are the indices of the waypoints, so that each piece shows which ones it lies
    # between.
    smoothed = smooth(
        np.column_stack((places, np.arange(count, dtype=np.float64))),
        problem.limits.turn_radius_m,
        problem.headings,
    )
    runs = np.hypot(*np.diff(places, axis=0).T)
    if smoothed.impossible_arcs or not runs.any():
        return None
    above, heights, level = [], [], np.zeros(count)
    rises, flown = [np.diff(np.eye(count), axis=0)], [runs]
    with np.errstate(invalid="ignore"):  # A segment without horizontal length has no direction.
        ways = np.diff(places, axis=0) / runs[:, None]
    arcs = []
    profiles = _profiles(problem.surface, smoothed.pieces, problem.ds_m / FINE)
    for piece, (at, ground) in zip(smoothed.pieces, profiles, strict=True):
        start = _between(piece.start[2], count)
        stop = _between(piece.start[2] + piece.rise_m, count)
        above.append(np.outer(1 - at, start) + np.outer(at, stop))
        heights.append(ground)
        level += 0.5 * piece.run_m * (start + stop)
        if isinstance(piece, Arc) and piece.run_m > _SHORT_ARC_M:
            rises.append((stop - start)[None])
            flown.append(np.array([piece.run_m]))
            arcs.append(piece)
    z = _solved(
        problem,
        prices,
        np.concatenate(above),
        np.concatenate(heights),
        level,
        np.concatenate(rises),
        np.concatenate(flown),
        _slopes_allowed(problem, ways, arcs),
        step_m,
    )
    if z is None:
        return None
    if step_m > 0:
        z[1:-1] = base_m + np.ceil((z[1:-1] - base_m) / step_m) * step_m
    return np.column_stack((places, z))


def _slopes_allowed(problem: Problem, ways: Floats, arcs: Sequence[Arc]) -> tuple[Floats, Floats]:
    """Return the steepest climbs and descents, as tangents: on straight pieces, then on arcs.

    All directions are passed at once, because each call in wind solves for the slopes by bisection.
    """
    turns = [_fastest_directions(arc, problem.frame_wind) for arc in arcs]
    limits = problem.slope_limits(*np.concatenate((ways, *turns)).T)
    firsts = len(ways) + np.cumsum([0, *map(len, turns)])[:-1]
    climb, descent = (
        np.concatenate((limit[: len(ways)], np.minimum.reduceat(limit, firsts)))
        if len(arcs)
        else limit
        for limit in limits
    )
    return climb, descent


def _fastest_directions(arc: Arc, wind: tuple[float, float]) -> Floats:
    """Return the directions of an arc in which the wind may help most, (2 or 3, 2).

    They are both ends and, if the arc passes it, the direction of the wind.
    """
    first = math.atan2(arc.heading[1], arc.heading[0])
    angles = [first, first + arc.turn_rad]
    side = math.copysign(1.0, arc.turn_rad)
    downwind = (side * (math.atan2(wind[1], wind[0]) - first)) % (2 * math.pi)
    if downwind < abs(arc.turn_rad):
        angles.append(first + side * downwind)
    return np.column_stack((np.cos(angles), np.sin(angles)))


def _between(at: float, count: int) -> Floats:
    """Return the weights of all waypoints' altitudes at ``at``, given in waypoint indices."""
    before = min(int(at), count - 2)
    weights = np.zeros(count)
    weights[before : before + 2] = before + 1 - at, at - before
    return weights


def _profiles(
    terrain: Terrain, pieces: Sequence[Straight | Arc], finest_m: float
) -> Iterator[tuple[Floats, Floats]]:
    """Yield the ground that each piece must clear: shares of its length, and heights there.

    Straight pieces are cut where the nearest node changes, arcs into parts of at most ``finest_m``.
    """
    cuts = [
        _borders(terrain, piece)
        if isinstance(piece, Straight)
        else np.linspace(0.0, 1.0, math.ceil(piece.run_m / finest_m) + 1)
        for piece in pieces
    ]
    middles = np.concatenate(
        [
            piece.points(0.5 * (at[1:] + at[:-1]))[:, :2]
            for piece, at in zip(pieces, cuts, strict=True)
        ]
    )
    # Voids have no height to clear; the evaluation of the path detects them.
    grounds = np.nan_to_num(terrain.ground(*middles.T), nan=terrain.lowest)
    ends = np.cumsum([len(at) - 1 for at in cuts])
    for piece, at, part in zip(pieces, cuts, np.split(grounds, ends[:-1]), strict=True):
        # Within a part of an arc, the nearest node may change to the node of the next part.
        ground = part if isinstance(piece, Straight) else _with_neighbours(part)
        at, ground = np.repeat(at, 2)[1:-1], np.repeat(ground, 2)
        outer = _upper_hull(at, ground)
        yield at[outer], ground[outer]


def _with_neighbours(values: Floats) -> Floats:
    """Return the maximum of each value and of its neighbours."""
    highest = values.copy()
    np.maximum(highest[1:], values[:-1], out=highest[1:])
    np.maximum(highest[:-1], values[1:], out=highest[:-1])
    return highest


def _borders(terrain: Terrain, piece: Straight) -> Floats:
    """Return the shares of a straight piece at which the nearest node changes, with 0 and 1."""
    shares = [np.array([0.0, 1.0])]
    x, y, _ = piece.start
    for at, way, side in (
        (x, piece.heading[0] * piece.run_m, terrain.dx_m),
        (y, piece.heading[1] * piece.run_m, terrain.dy_m),
    ):
        if way != 0:
            first, last = sorted((at / side - 0.5, (at + way) / side - 0.5))
            lines = np.arange(math.ceil(first), math.floor(last) + 1)
            shares.append(((lines + 0.5) * side - at) / way)
    return np.unique(np.clip(np.concatenate(shares), 0.0, 1.0))


def _upper_hull(at: Floats, ground: Floats) -> NDArray[np.int64]:
    """Return the indices of the points that a line must clear in order to clear all points."""
    outer = np.empty(len(at), dtype=np.int64)
    return outer[: _hull_size(at, ground, outer)]


@compiled
def _hull_size(at: Floats, ground: Floats, outer: NDArray[np.int64]) -> int:
    """Write the indices to ``outer`` and return their number: Andrew's chain.

    Compiled, because there are thousands of short profiles, and Qhull takes longer to start.
    """
    size = 0
    for point in range(len(at)):
        while size > 1:
            one, other = outer[size - 2], outer[size - 1]
            rise = (ground[point] - ground[one]) * (at[other] - at[one])
            if rise < (ground[other] - ground[one]) * (at[point] - at[one]):
                break
            size -= 1
        outer[size] = point
        size += 1
    return size


def _solved(
    problem: Problem,
    prices: Prices,
    above: Floats,
    heights: Floats,
    level: Floats,
    rises: Floats,
    runs: Floats,
    slopes_allowed: tuple[Floats, Floats],
    step_m: float,
) -> Floats | None:
    """Solve for the altitudes of all waypoints, the climb of each segment, and the excess slope.

    Parameters
    ----------
    above, heights : (m, n) and (m,) float64
        Weights of altitudes, and ground to clear.
    level : (n,) float64
        Weights of the integral of altitude over length, metres.
    rises, runs : (p, n) and (p,) float64
        Weights of the rise on a run, and the length of the run in metres: segments, then arcs.
    slopes_allowed : (p,) and (p,) float64
        Steepest climb and descent of each run, as tangents.
    """
    count = len(level)
    segments, slopes = count - 1, len(rises)
    margin = _TOLERANCE if problem.rules is None else _SLOPE_MARGIN
    climb, descent = (limit - margin for limit in slopes_allowed)
    # Rounding up may add this much to a rise or take this much from it.
    more = step_m * np.maximum(rises[:, 1:-1], 0).sum(axis=1)
    less = step_m * np.maximum(-rises[:, 1:-1], 0).sum(axis=1)
    excess = np.column_stack((np.zeros((slopes, segments)), -runs))
    paid = -np.eye(segments, segments + 1)
    matrix = np.concatenate(
        (
            np.column_stack((-above, np.zeros((len(above), segments + 1)))),
            np.column_stack((rises, excess)),
            np.column_stack((-rises, excess)),
            np.column_stack((rises[:segments], paid)),
        )
    )
    limits = np.concatenate(
        (-heights - _CLEARANCE_M, runs * climb - more, runs * descent - less, np.zeros(segments))
    )
    bounds = np.full((count + segments + 1, 2), (-np.inf, np.inf))
    bounds[[0, count - 1]] = [[problem.start[2]] * 2, [problem.goal[2]] * 2]
    bounds[count:-1, 0] = -prices.glide * runs[:segments]
    bounds[-1, 0] = 0.0
    # In metres of altitude over the whole path.
    way_m = runs[:segments].sum()
    work = np.full(segments, prices.work / prices.area / way_m)
    costs = np.concatenate((level / way_m, work, [_TOO_STEEP]))
    solution = minimised(costs, matrix, limits, bounds)
    steep = solution is None or solution[-1] > margin - _TOLERANCE
    if steep and problem.rules is not None:
        # The raster may require more than the rules: then fly too low where there is no
        # alternative.
        rows = len(above)
        too_low = np.concatenate((-np.eye(rows), np.zeros((len(matrix) - rows, rows))))
        solution = minimised(
            np.concatenate((costs, np.full(rows, _TOO_LOW))),
            np.column_stack((matrix, too_low)),
            limits,
            np.concatenate((bounds, np.tile([[0.0, np.inf]], (rows, 1)))),
        )
    return None if solution is None else solution[:count]
