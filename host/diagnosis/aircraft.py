"""Limits of the aircraft as reasons: climb, descent, power, fuel and stall.

Pits and walls are ends that no allowed climb leaves or no allowed descent reaches. An
aircraft that leaves a pit gains altitude in proportion to the length of its route. If no circle
of the turn radius fits into the pit, the route cannot turn round, so it is not much longer than the
shortest one: a pit that is too deep for this length is closed. If a circle fits, the aircraft could
circle up. Since no planner circles, the reason given is that the shortest routes are too steep,
which is not a proof.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pathgene.host.diagnosis.bounds import Bounds
from pathgene.host.diagnosis.reach import Reach, has_room
from pathgene.host.diagnosis.reason import Figure, Reason, rounded_down, rounded_up
from pathgene.host.evaluation.aircraft_limits import CLIMB, DESCENT, FUEL, POWER, STALL
from pathgene.host.problem.problem import Problem


__all__ = ["fuel_reasons", "power_reasons", "slope_reasons", "stall_reasons"]

Floats = NDArray[np.float64]

# Without turning around, a route is at most pi / 2 times as long as the shortest; rounded up.
_DETOUR = 2.0
# Maximum number of nodes on the longer side of the grid that gives a sufficient limit.
_MOST_NODES = 400
_HALVINGS = 12
_STEEPEST_DEG = 85.0


class _Pit:
    """The routes out of one end: from the start upwards, or from the goal backwards and upwards."""

    def __init__(self, bounds: Bounds, end: str) -> None:
        problem, terrain = bounds.problem, bounds.problem.terrain
        self.bounds = bounds
        own, other = problem.start, problem.goal
        if end == "goal":
            own, other = other, own
        self.x, self.y, self.z = own
        self.other = other
        self.every = math.ceil(max(terrain.shape) / _MOST_NODES)
        self.sides = self.every * terrain.dx_m, self.every * terrain.dy_m

    def node(self, x: float, y: float, every: int) -> tuple[int, int]:
        """Return the node of a point on a grid that is coarser by the factor ``every``."""
        row, column = self.bounds.problem.terrain.nearest_nodes(x, y)
        return int(row) // every, int(column) // every

    def searched(self, heights: Floats, slope: float) -> Reach:
        """Return the reach of the shortest routes on the search surface."""
        return Reach.of(heights, self.sides, self.node(self.x, self.y, self.every), self.z, slope)

    def surface(self) -> Floats:
        """Return the search surface on a coarser grid, as high as the highest of each block."""
        problem = self.bounds.problem
        raised = np.where(problem.blocked_raster, np.inf, problem.surface.elevation)
        rows, columns = (np.arange(0, nodes, self.every) for nodes in raised.shape)
        pooled: Floats = np.maximum.reduceat(np.maximum.reduceat(raised, rows), columns, axis=1)
        pooled[self.node(self.x, self.y, self.every)] = self.z
        pooled[self.node(*self.other[:2], self.every)] = self.other[2]
        return pooled

    def is_proven(self, slope: float) -> bool:
        """Return whether it is proven that no route leads out at a slope."""
        problem, terrain = self.bounds.problem, self.bounds.problem.terrain
        if not math.isfinite(slope):
            return False
        heights = self.bounds.lowest.copy()
        there = self.node(*self.other[:2], 1)
        heights[there] = min(heights[there], self.other[2])
        sides = terrain.dx_m, terrain.dy_m
        gained = slope * _DETOUR
        # The route may begin and end at the far sides of its first and last squares.
        slack = gained * 2 * math.hypot(*sides)
        reach = Reach.of(heights, sides, self.node(self.x, self.y, 1), self.z + slack, gained)
        return not reach.nodes[there] and not has_room(
            reach.nodes, sides, problem.limits.turn_radius_m
        )


def slope_reasons(bounds: Bounds) -> Iterator[Reason]:
    """Yield the climb limit, the descent limit and the power, if they close every short route."""
    problem = bounds.problem
    if problem.limits.climb_rad <= 0:
        return
    for limit, flown, slope_bound in (
        (CLIMB, problem.limits.climb_rad, bounds.climb_slope),
        (DESCENT, problem.limits.descent_rad, bounds.descent_slope),
    ):
        pit = _Pit(bounds, limit.end)
        heights = pit.surface()
        there = pit.node(*pit.other[:2], pit.every)
        given_deg = limit.degrees(problem.aircraft)
        if pit.searched(heights, math.tan(flown)).nodes[there]:
            continue
        would_do = _least_slope(pit, heights, there, math.tan(flown))
        by_file = math.radians(given_deg)
        by_power = flown < by_file and pit.searched(heights, math.tan(by_file)).nodes[there]
        if would_do is None:
            continue
        slope, place = would_do
        degrees = rounded_up(math.degrees(math.atan(slope)))
        if by_power:
            needed = math.tan(math.radians(degrees))
            needed = rounded_up(POWER.climbing_power(problem.aircraft, needed), 1.0)
            yield Reason(
                code=POWER.name,
                sentence=POWER.climb_advice(problem, degrees, place, needed),
                proven=pit.is_proven(bounds.power_slope),
                place=place,
                figure=_power_figure(problem, needed),
                end=limit.end,
            )
            continue
        proven = pit.is_proven(slope_bound)
        reached = pit.searched(heights, math.tan(flown)).nodes
        yield Reason(
            code=limit.name,
            sentence=limit.advice(problem, degrees, place, proven=proven),
            proven=proven,
            place=place,
            figure=Figure(limit.name, given_deg, degrees, "deg"),
            end=limit.end,
            region=_spread(reached, pit.every, problem),
        )


def _power_figure(problem: Problem, needed: float) -> Figure:
    assert problem.aircraft.engine_power_W is not None
    return Figure(POWER.name, problem.aircraft.engine_power_W, needed, POWER.unit)


def _least_slope(
    pit: _Pit, heights: Floats, there: tuple[int, int], too_low: float
) -> tuple[float, tuple[float, float]] | None:
    """Return the gentlest slope that connects both ends, and the place that requires it."""
    low, high = too_low, math.tan(math.radians(_STEEPEST_DEG))
    if not pit.searched(heights, high).nodes[there]:
        return None
    for _ in range(_HALVINGS):
        middle = math.sqrt(max(low, 1e-3) * high)
        low, high = (low, middle) if pit.searched(heights, middle).nodes[there] else (middle, high)
    reach = pit.searched(heights, high)
    way = reach.way(there)
    rows, columns = way[1:].T
    needed = (heights[rows, columns] - pit.z) / reach.flown_m[rows, columns]
    row, column = way[1 + int(np.argmax(needed))]
    terrain = pit.bounds.problem.terrain
    middle_node = pit.every // 2
    x = min(int(column) * pit.every + middle_node, terrain.shape[1] - 1) * terrain.dx_m
    y = min(int(row) * pit.every + middle_node, terrain.shape[0] - 1) * terrain.dy_m
    return high, (x, y)


def _spread(nodes: NDArray[np.bool_], every: int, problem: Problem) -> NDArray[np.bool_]:
    """Return nodes of the coarse grid, spread to the terrain's grid."""
    rows, columns = problem.terrain.shape
    fine: NDArray[np.bool_] = np.repeat(np.repeat(nodes, every, axis=0), every, axis=1)
    return fine[:rows, :columns]


def power_reasons(bounds: Bounds) -> Iterator[Reason]:
    """Yield the reason that the engine cannot hold level flight, if the path needs it."""
    problem, slope = bounds.problem, bounds.power_slope
    if problem.rules is None or problem.aircraft.engine_power_W is None or not slope < 0:
        return
    z = problem.start[2]
    way = math.dist(problem.start[:2], problem.goal[:2])
    if z + slope * way < problem.goal[2] - 1e-3:
        low_m = problem.goal[2] - z - slope * way
        place, consequence = problem.goal[:2], f"is {low_m:.0f} m too low at the goal"
    elif (barrier := bounds.barrier(z)).closed:
        place = barrier.ring().place
        consequence = "no way to the goal stays below the altitude of the start"
    else:
        return
    needed = rounded_up(POWER.climbing_power(problem.aircraft, 0.0), 1.0)
    yield Reason(
        code=POWER.name,
        sentence=POWER.level_advice(problem, needed, consequence),
        proven=True,
        place=place,
        figure=_power_figure(problem, needed),
    )


def fuel_reasons(bounds: Bounds) -> Iterator[Reason]:
    """Yield the reason that the fuel does not even last for the straight line."""
    problem, given = bounds.problem, bounds.problem.aircraft.fuel_weight_N
    if problem.rules is None or given is None:
        return
    least, reserve = FUEL.least(problem), problem.rules.reserve
    allowed = problem.limits.fuel_N
    if least <= allowed:
        return
    burnt, tank = (rounded_up(fuel, _step(fuel)) for fuel in (least, least / (1.0 - reserve)))
    yield Reason(
        code=FUEL.name,
        sentence=FUEL.advice(reserve, burnt, rounded_down(allowed, _step(allowed)), tank),
        proven=True,
        place=problem.goal[:2],
        figure=Figure(FUEL.name, given, tank, FUEL.unit),
    )


def _step(fuel: float) -> float:
    """Return the value of a step in the third significant digit."""
    return 10.0 ** (math.floor(math.log10(fuel)) - 2) if fuel > 0 else 1.0


def stall_reasons(bounds: Bounds) -> Iterator[Reason]:
    """Yield the reason that the aircraft stalls in any turn while the straight line is blocked."""
    problem, aircraft = bounds.problem, bounds.problem.aircraft
    if problem.rules is None or math.isfinite(problem.limits.turn_radius_m):
        return
    start, goal = np.array(problem.start[:2]), np.array(problem.goal[:2])
    cell = min(problem.terrain.dx_m, problem.terrain.dy_m)
    count = math.ceil(4 * float(np.hypot(*(goal - start))) / cell) + 2
    x, y = np.linspace(start, goal, count).T
    lowest = bounds.lowest[problem.terrain.nearest_nodes(x, y)]
    closed = lowest > problem.limits.ceiling_m
    for index in bounds.closing_zones(problem.limits.ceiling_m):
        zone = problem.zones[index]
        closed |= zone.covers(x, y).diagonal()
    if not closed.any():
        return
    at = int(np.argmax(closed))
    place = float(x[at]), float(y[at])
    speed = STALL.least_speed_m_s(problem)
    yield Reason(
        code="turn",
        sentence=STALL.advice(problem, rounded_up(problem.limits.stall_speed_m_s), place),
        proven=True,
        place=place,
        figure=Figure(
            STALL.name,
            aircraft.aerodynamic_speed_m_s,
            None if speed is None else rounded_up(speed),
            STALL.unit,
        ),
    )
