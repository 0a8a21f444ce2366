"""Search in a box around start and goal, for planners whose work grows with the size of the map.

The rasters of a search cover the box instead of the map. A path that leaves the box is longer than
a detour past its side, so its cost has a lower bound: a cheaper path inside the box is better than
all paths outside.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.reference import problem_utopia
from pathgene.host.planners.base import Observer, Options, Progress, Result, Stop
from pathgene.host.problem.limits import pressure_on_wing
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone


__all__ = ["plan_in_box"]

Path = NDArray[np.float64]
#: :meth:`pathgene.host.planners.base.Planner.plan`.
Plan = Callable[[Evaluator, Options, Progress | None, Stop | None], Result]

# Maps of up to this many nodes are searched as a whole.
_MOST_WHOLE = 1_500_000
# Largest share of the map that a box may cover.
_MOST_SHARE = 0.5
# Room around the ends: the distance between them, but at least this many turn radii. A larger box
# has this many times the room.
_LEAST_RADII = 20.0
_GROWTH = 3.0
# Time limit of the next search where the last one has used the time up.
_LEAST_S = 1e-3


def plan_in_box(
    plan: Plan,
    evaluator: Evaluator,
    options: Options,
    progress: Progress | None = None,
    stop: Stop | None = None,
    *,
    most: int | None = None,
) -> Result:
    """Plan in a box of the map, and in a larger one until no better path can be outside.

    Maps of up to 1.5 million nodes, and problems whose box covers more than half of the map, are
    planned over the whole map at once. The path is judged over the whole map.

    Parameters
    ----------
    plan : callable
        Plans a problem, as :meth:`pathgene.host.planners.base.Planner.plan` does.
        ``options.time_limit_s`` applies to all searches together.
    most : int, optional
        Maximum number of boxes, for a planner that searches near the ends: a feasible path in one
        of them is enough, and the map follows where there is none.

    Returns
    -------
    Result
        The record of the search with the best path, with the seconds and evaluations of all.
    """
    best: Result | None = None
    for box in itertools.islice(_boxes(evaluator.problem), most):
        try:
            problem = box.problem(evaluator.problem)
        except InputError:  # An end that rounding has moved into a zone.
            break
        inner = Evaluator(problem, ds_m=evaluator.ds_m, threads=evaluator.threads)
        found = plan(inner, _remaining(options, best), box.shown(progress), stop)
        is_over = found.stopped_by != "generations"
        best = _better(best, box.whole(evaluator, found, judge=is_over))
        is_enough = most is not None or best.evaluation.cost <= box.least_cost_outside
        if is_over or (best.evaluation.feasible and is_enough):
            return best
    result = plan(evaluator, _remaining(options, best), progress, stop)
    return _better(best, result)


def _remaining(options: Options, spent: Result | None) -> Options:
    if options.time_limit_s is None or spent is None:
        return options
    left_s = max(options.time_limit_s - spent.seconds["total"], _LEAST_S)
    return dataclasses.replace(options, time_limit_s=left_s)


def _better(one: Result | None, other: Result) -> Result:
    """Return the result with the better feasible path, by default the later, with all the work."""
    if one is None:
        return other
    is_one = one.evaluation.feasible and one.evaluation.fitness >= other.evaluation.fitness
    fitter = one if is_one else other
    names = {**one.seconds, **other.seconds}
    return dataclasses.replace(
        fitter,
        evaluations=one.evaluations + other.evaluations,
        cut_short=one.cut_short + other.cut_short,
        seconds={name: one.seconds.get(name, 0.0) + other.seconds.get(name, 0.0) for name in names},
        stopped_by=other.stopped_by,
        failure=other.failure,
    )


@dataclass(frozen=True)
class _Box:
    """A part of the map.

    Parameters
    ----------
    rows, columns : slice
        Its nodes.
    west_m, south_m, east_m, north_m : float
        Its edges in the frame of the map.
    least_cost_outside : float
        No feasible path that leaves the box costs less.
    """

    rows: slice
    columns: slice
    west_m: float
    south_m: float
    east_m: float
    north_m: float
    least_cost_outside: float

    def problem(self, whole: Problem) -> Problem:
        """Return the problem over the box, in the box's frame.

        Raises
        ------
        InputError
            If an end is not a good one there.
        """
        terrain = whole.terrain.part(self.rows, self.columns)
        margin_m = 0.0 if whole.rules is None else whole.rules.zone_margin_m
        zones = (
            zone.moved(-self.west_m, -self.south_m)
            for zone in whole.zones
            if self._meets(zone, margin_m + max(terrain.dx_m, terrain.dy_m))
        )
        start, goal = (
            (x - self.west_m, y - self.south_m, z) for x, y, z in (whole.start, whole.goal)
        )
        problem = dataclasses.replace(
            whole, terrain=terrain, start=start, goal=goal, zones=tuple(zones)
        )
        # The ground outside counts for it.
        problem.__dict__["cost_base_m"] = whole.cost_base_m
        return problem

    def _meets(self, zone: Zone, margin_m: float) -> bool:
        west, south, east, north = zone.footprint.box
        return (
            west - margin_m <= self.east_m
            and south - margin_m <= self.north_m
            and east + margin_m >= self.west_m
            and north + margin_m >= self.south_m
        )

    def whole(self, evaluator: Evaluator, found: Result, *, judge: bool) -> Result:
        """Return a result over the box as one over the map of ``evaluator``.

        A path that breaks a limit keeps the verdict of the box unless ``judge``.
        """
        path = self.moved(found.path)
        path[0], path[-1] = evaluator.problem.start, evaluator.problem.goal
        is_judged = judge or found.evaluation.feasible
        return dataclasses.replace(
            found,
            path=path,
            evaluation=evaluator.evaluate(path) if is_judged else found.evaluation,
            hardware=self._placed(found.hardware),
            archive=[(fitness, self.moved(each)) for fitness, each in found.archive],
        )

    def _placed(self, hardware: dict[str, Any] | None) -> dict[str, Any] | None:
        """Return the facts on a chip with the place of its map in the frame of the whole map."""
        if hardware is None or "map" not in hardware:
            return hardware
        east_m, north_m, base_m = hardware["map"]["offset_m"]
        offset_m = [east_m + self.west_m, north_m + self.south_m, base_m]
        return {**hardware, "map": {**hardware["map"], "offset_m": offset_m}}

    def moved(self, path: Path) -> Path:
        """Return a path in the frame of the map."""
        moved: Path = path + np.array((self.west_m, self.south_m, 0.0))
        return moved

    def shown(self, progress: Progress | None) -> Progress | None:
        """Return a progress that gets the paths in the frame of the map."""
        return _Shown(progress, self) if isinstance(progress, Observer) else progress


@dataclass(frozen=True)
class _Shown:
    observer: Observer
    box: _Box

    def __call__(self, generation: int, best: float, mean: float) -> object:
        return self.observer(generation, best, mean)

    def improved(self, path: Path) -> object:
        return self.observer.improved(self.box.moved(path))


def _boxes(problem: Problem) -> Iterator[_Box]:
    """Yield boxes with more and more room around the ends, while they are much smaller than a map.

    There is none for a mission as a whole, whose way has more points.
    """
    terrain = problem.terrain
    nodes = terrain.elevation.size
    if nodes <= _MOST_WHOLE or len(problem.way) > 2:
        return
    (x0, y0, _), (x1, y1, _) = problem.start, problem.goal
    room_m = max(math.hypot(x1 - x0, y1 - y0), _LEAST_RADII * problem.limits.turn_radius_m)
    while math.isfinite(room_m):
        columns = _part(x0, x1, room_m, terrain.dx_m, terrain.shape[1])
        rows = _part(y0, y1, room_m, terrain.dy_m, terrain.shape[0])
        if (columns.stop - columns.start) * (rows.stop - rows.start) > _MOST_SHARE * nodes:
            return
        yield _Box(
            rows,
            columns,
            columns.start * terrain.dx_m,
            rows.start * terrain.dy_m,
            (columns.stop - 1) * terrain.dx_m,
            (rows.stop - 1) * terrain.dy_m,
            _least_cost_outside(problem, rows, columns),
        )
        room_m *= _GROWTH


def _part(one: float, other: float, room_m: float, side_m: float, nodes: int) -> slice:
    """Return the nodes of an axis from ``room_m`` before both places to ``room_m`` after them."""
    first = max(math.floor((min(one, other) - room_m) / side_m), 0)
    return slice(first, min(math.ceil((max(one, other) + room_m) / side_m) + 1, nodes))


def _least_cost_outside(problem: Problem, rows: slice, columns: slice) -> float:
    """Return a lower bound of the cost of paths that leave a box; infinite for the whole map.

    The path is at least as long as the shortest way from start to goal past a side of the box, and
    nowhere below the lowest ground. It burns at least the fuel of level flight and of the climb
    from start to goal, with the drag of the steepest slope and the most helpful wind.
    """
    terrain, aircraft = problem.terrain, problem.aircraft
    (x0, y0, z0), (x1, y1, z1) = problem.start, problem.goal
    # Paths in the box keep their corridor inside it, and searches keep off its outer cells.
    inset_m = 0.0 if problem.rules is None else problem.rules.corridor_m
    lengths = [math.inf]
    for part, one, other, aside, side_m, count in (
        (columns, x0, x1, y1 - y0, terrain.dx_m, terrain.shape[1]),
        (rows, y0, y1, x1 - x0, terrain.dy_m, terrain.shape[0]),
    ):
        inside = inset_m + 2 * side_m
        if part.start > 0:
            edge = part.start * side_m + inside
            lengths.append(math.hypot(one - edge + other - edge, aside))
        if part.stop < count:
            edge = (part.stop - 1) * side_m - inside
            lengths.append(math.hypot(edge - one + edge - other, aside))
    length_m = min(lengths)
    if math.isinf(length_m):
        return math.inf
    limits, best = problem.limits, problem_utopia(problem)
    steepest = max(limits.climb_rad, limits.descent_rad)
    lift_area = pressure_on_wing(aircraft)
    # The weight falls by the fuel that is burned, and so does the induced drag.
    drag = lift_area * aircraft.zero_lift_drag_coefficient
    least_weight = max(aircraft.weight_N - 2 * best.fuel_N, 0.0)
    drag += aircraft.induced_drag_factor * (least_weight * math.cos(steepest)) ** 2 / lift_area
    work = drag * length_m + min(least_weight * (z1 - z0), aircraft.weight_N * (z1 - z0))
    wind = math.hypot(*problem.wind)
    airspeed = aircraft.cruise_speed_m_s
    burn = aircraft.specific_fuel_consumption_N_per_Ws / aircraft.propeller_efficiency
    fuel = burn * max(work, 0.0) * airspeed / (airspeed + wind)
    area = max(terrain.lowest - problem.cost_base_m, 0.0) * length_m
    return 0.5 * area / (best.altitude_m * best.length_m) + 0.5 * fuel / best.fuel_N
