"""Pits and walls: ends that no allowed climb leaves or no allowed descent reaches.

An aircraft that leaves a pit gains altitude in proportion to the length of its route. If no circle
of the turn radius fits into the pit, the route cannot turn around, so it is not much longer than
the shortest route: a pit that is too deep for this length is closed. If a circle fits, the aircraft
could circle up. Since no planner circles, the reason given is that the shortest routes are too
steep, which is not a proof.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pathgene.host.diagnosis.bounds import Bounds
from pathgene.host.diagnosis.energy import least_power
from pathgene.host.diagnosis.reach import Reach, has_room
from pathgene.host.diagnosis.reason import Figure, Reason, rounded_up
from pathgene.host.problem.problem import Problem


__all__ = ["slope_reasons"]

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
        self.bounds, self.end = bounds, end
        own, other = problem.start, problem.goal
        self.limit, degrees = "climb", problem.aircraft.max_climb_deg
        self.slope_bound = bounds.climb_slope
        if end == "goal":
            own, other = other, own
            self.limit, degrees = "descent", problem.aircraft.max_descent_deg
            self.slope_bound = bounds.descent_slope
        self.degrees = degrees
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
    for end in ("start", "goal"):
        pit = _Pit(bounds, end)
        heights = pit.surface()
        there = pit.node(*pit.other[:2], pit.every)
        flown = problem.limits.climb_rad if end == "start" else problem.limits.descent_rad
        if pit.searched(heights, math.tan(flown)).nodes[there]:
            continue
        would_do = _least_slope(pit, heights, there, math.tan(flown))
        by_file = math.radians(pit.degrees)
        by_power = flown < by_file and pit.searched(heights, math.tan(by_file)).nodes[there]
        if would_do is None:
            continue
        slope, place = would_do
        degrees = rounded_up(math.degrees(math.atan(slope)))
        if by_power:
            yield _power(pit, degrees, place, pit.is_proven(bounds.power_slope))
            continue
        proven = pit.is_proven(pit.slope_bound)
        reached = pit.searched(heights, math.tan(flown)).nodes
        yield Reason(
            code=pit.limit,
            sentence=_sentence(pit, degrees, place, proven),
            proven=proven,
            place=place,
            figure=Figure(pit.limit, pit.degrees, degrees, "deg"),
            end=end,
            region=_spread(reached, pit.every, problem),
        )


def _sentence(pit: _Pit, degrees: float, place: tuple[float, float], proven: bool) -> str:
    at = f"near ({place[0]:.0f}, {place[1]:.0f}) m"
    verb = "out of" if pit.end == "start" else "down to"
    kind = "climb" if pit.end == "start" else "descent"
    sentence = (
        f"Every short way {verb} the {pit.end} is too steep: {at} it takes a {kind} of "
        f"{degrees:.1f} degrees, and the limit is {pit.degrees:g}"
    )
    if proven:
        return f"{sentence}; there is no room to circle."
    return f"{sentence}; there may be room to circle, which no planner does."


def _power(pit: _Pit, degrees: float, place: tuple[float, float], proven: bool) -> Reason:
    """Return the reason that the engine cannot hold the climb that the aircraft's file allows."""
    problem, aircraft = pit.bounds.problem, pit.bounds.problem.aircraft
    assert aircraft.engine_power_W is not None
    needed = rounded_up(least_power(pit.bounds, math.tan(math.radians(degrees))), 1.0)
    return Reason(
        code="power",
        sentence=f"The engine of {aircraft.name} gives {aircraft.engine_power_W:g} W, enough for "
        f"a climb of {math.degrees(problem.limits.climb_rad):.1f} degrees; the way out of the "
        f"start takes {degrees:.1f} degrees near ({place[0]:.0f}, {place[1]:.0f}) m, "
        f"{needed:.0f} W.",
        proven=proven,
        place=place,
        figure=Figure("power", aircraft.engine_power_W, needed, "W"),
        end=pit.end,
    )


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
