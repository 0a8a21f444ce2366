"""The surface that paths clear, and the raised rasters that planners search above.

The surface under a point is the greater of the height of its nearest node and the height between
the four nodes around it. Near start and goal less clearance is demanded, or no aircraft could take
off: see :class:`Demand`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from host.problem.aircraft import Aircraft
from host.problem.ends import Point
from host.problem.rules import Rules
from host.problem.zone_raster import blocked_cells
from host.problem.zones import Circle, Polygon, Zone
from host.terrain import Terrain


__all__ = ["Demand", "SearchRasters", "surface_below"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Height of a void in sums with weights, where an infinite height would give NaN.
_VOID_M = 1e300
_ANY_VOID_M = 1e200
# Cells around an end in which the rasters demand what the end's climb allows.
_CELLS_AT_ENDS = 4.0


def surface_below(terrain: Terrain, x: Floats, y: Floats) -> Floats:
    """Return the surface under points (k,) of the frame, metres; infinite over a void.

    Off the map the nearest point of its edge stands in.
    """
    rows, columns = terrain.shape
    heights = np.where(np.isnan(terrain.elevation), _VOID_M, terrain.elevation)
    gx = np.clip(x / terrain.dx_m, 0, columns - 1)
    gy = np.clip(y / terrain.dy_m, 0, rows - 1)
    column = np.minimum(gx.astype(np.intp), columns - 2)
    row = np.minimum(gy.astype(np.intp), rows - 2)
    east, north = gx - column, gy - row
    below = (1 - east) * heights[row, column] + east * heights[row, column + 1]
    above = (1 - east) * heights[row + 1, column] + east * heights[row + 1, column + 1]
    between = (1 - north) * below + north * above
    highest = np.maximum(between, heights[terrain.nearest_nodes(x, y)])
    return np.where(highest > _ANY_VOID_M, np.inf, highest)


@dataclass(frozen=True)
class Demand:
    """The clearance demanded at a horizontal distance from both ends.

    It is the least of the rule's clearance and, for each end, the end's own height over the surface
    plus half the tangent of the climb limit (of the descent limit at the goal) times the distance.

    Parameters
    ----------
    clearance_m : float
        The rule.
    heights_m : (float, float)
        Height of start and goal over the surface.
    slopes : (float, float)
        Growth of the demand by distance from start and goal.
    ends : ((float, float, float), (float, float, float))
        Start and goal.
    """

    clearance_m: float
    heights_m: tuple[float, float]
    slopes: tuple[float, float]
    ends: tuple[Point, Point]

    @staticmethod
    def of(
        terrain: Terrain, start: Point, goal: Point, aircraft: Aircraft, clearance_m: float
    ) -> Demand:
        """Return the demand of a flight."""
        ends = np.array([start, goal])
        heights = ends[:, 2] - surface_below(terrain, ends[:, 0], ends[:, 1])
        # An end beside a void is itself too low, but what it lacks is no excuse for the path.
        height_start, height_goal = np.where(np.isfinite(heights), heights, 0.0).tolist()
        return Demand(
            clearance_m,
            (height_start, height_goal),
            (
                0.5 * math.tan(math.radians(aircraft.max_climb_deg)),
                0.5 * math.tan(math.radians(aircraft.max_descent_deg)),
            ),
            (start, goal),
        )

    def required_m(self, x: Floats, y: Floats, nearer_m: float = 0.0) -> Floats:
        """Return the clearance demanded at points, as if ``nearer_m`` nearer to both ends."""
        required = np.full(np.broadcast(x, y).shape, self.clearance_m)
        for height, slope, (at_x, at_y, _) in zip(
            self.heights_m, self.slopes, self.ends, strict=True
        ):
            away = np.maximum(np.hypot(x - at_x, y - at_y) - nearer_m, 0.0)
            required = np.minimum(required, height + slope * away)
        return required


class SearchRasters:
    """Rasters of the terrain's shape above which every sampled path keeps the rules, nearly always.

    The strict rule decides on each path; these rasters let planners search as if there were no
    rules. A node stands for its cell square.

    Parameters
    ----------
    terrain : Terrain
        The ground.
    demand : Demand
        Clearance demanded.
    zones : iterable of Zone
        No-fly zones; one whose time ends before it can be reached is left out.
    rules : Rules
        Corridor, margin of zones and ceiling above ground.
    fastest_m_s : float
        Greatest possible ground speed.

    Attributes
    ----------
    floor : (ny, nx) float64, metres
        Lowest altitude at each node: the highest surface within the corridor of any point of the
        square, the demanded clearance, and zones to be flown over; NaN over voids and near them.
    roof : (ny, nx) float64, metres, or None
        Highest altitude at each node: the ceiling above ground, and zones to be flown under;
        infinite where there is none. None if no node has one.
    nofly : (ny, nx) bool
        Nodes in zones that are neither flown over nor under.
    at_times : (ny, nx) bool
        The same of zones that are active at times.
    at_times_zones : tuple of Zone
        These zones.
    """

    def __init__(
        self,
        terrain: Terrain,
        demand: Demand,
        zones: Iterable[Zone],
        rules: Rules,
        fastest_m_s: float,
    ) -> None:
        self.floor = _floor(terrain, demand, rules.corridor_m)
        roof = np.full(terrain.shape, np.inf)
        if rules.ceiling_agl_m is not None:
            # The surface in a node's square is nowhere below the node.
            np.copyto(roof, terrain.elevation + rules.ceiling_agl_m, where=~terrain.voids)
        self.nofly = np.zeros(terrain.shape, dtype=bool)
        self.at_times = np.zeros(terrain.shape, dtype=bool)
        at_times = []
        start = demand.ends[0]
        for zone in zones:
            if zone.t1_s is not None:
                reach_m = fastest_m_s * zone.t1_s + rules.zone_margin_m
                if _least_distance_m(zone, start[0], start[1]) > reach_m:
                    continue
            cells = blocked_cells([zone], terrain, rules.zone_margin_m)
            if zone.lower_m is not None:
                lowest = zone.lower_m - rules.zone_margin_m
                under = cells & (self.floor + rules.clearance_m <= lowest)
                roof[under] = np.minimum(roof[under], lowest)
                cells &= ~under
            if zone.upper_m is None:
                if zone.t0_s is None and zone.t1_s is None:
                    self.nofly |= cells
                else:
                    self.at_times |= cells
                    at_times.append(zone)
            else:
                self.floor[cells] = np.maximum(
                    self.floor[cells], zone.upper_m + rules.zone_margin_m
                )
        self.at_times_zones = tuple(at_times)
        self.roof = roof if np.isfinite(roof).any() else None


def _least_distance_m(zone: Zone, x: float, y: float) -> float:
    """Return the distance from a point to a circle, or to the bounding box of a polygon."""
    if isinstance(zone, Circle):
        return math.hypot(zone.x_m - x, zone.y_m - y) - zone.radius_m
    assert isinstance(zone, Polygon)
    low, high = np.min(zone.ring, axis=0), np.max(zone.ring, axis=0)
    return float(np.hypot(*np.maximum(np.maximum(low - (x, y), (x, y) - high), 0.0)))


def _floor(
    terrain: Terrain,
    demand: Demand,
    corridor_m: float,
) -> Floats:
    """Return the surface around each node plus the demanded clearance, NaN near voids."""
    rows, columns = terrain.shape
    x: Floats = np.arange(columns, dtype=np.float64)[None, :] * terrain.dx_m
    y: Floats = np.arange(rows, dtype=np.float64)[:, None] * terrain.dy_m
    half_diagonal = 0.5 * math.hypot(terrain.dx_m, terrain.dy_m)
    heights = np.where(terrain.voids, _VOID_M, terrain.elevation)
    required = demand.required_m(x, y, -half_diagonal)
    floor: Floats = _highest_around(heights, terrain, corridor_m) + required
    # At the ends a node demands no more than the aircraft can climb from there.
    for (at_x, at_y, z), slope, height in zip(
        demand.ends, demand.slopes, demand.heights_m, strict=True
    ):
        away = np.maximum(np.hypot(x - at_x, y - at_y) - half_diagonal, 0.0)
        ramp_m = max(demand.clearance_m - height, 0.0) / slope
        near = away <= _CELLS_AT_ENDS * half_diagonal + ramp_m
        least = heights + demand.required_m(x, y, half_diagonal)
        eased = np.maximum(least, np.minimum(floor, z + slope * away))
        floor = np.where(near, eased, floor)
    return np.where(floor > _ANY_VOID_M, np.nan, floor)


def _highest_around(heights: Floats, terrain: Terrain, corridor_m: float) -> Floats:
    """Return the highest surface within ``corridor_m`` of each node's square, in both axes."""
    reach = [0.5 + corridor_m / side for side in (terrain.dy_m, terrain.dx_m)]
    # Squares of nodes this far away are touched, too.
    nodes = [math.floor(cells + 0.5) for cells in reach]
    highest = _spread(_spread(heights, 0, nodes[0]), 1, nodes[1])
    for axis in (0, 1):
        for side in (-1, 1):
            # Between nodes, heights are linear along each axis: the extremes lie at the rim.
            rim = _moved(heights, axis, side * reach[axis])
            other = 1 - axis
            np.maximum(highest, _spread(rim, other, math.floor(reach[other])), out=highest)
            if axis == 0:
                for sign in (-1, 1):
                    np.maximum(highest, _moved(rim, 1, sign * reach[1]), out=highest)
    return highest


def _spread(raster: Floats, axis: int, nodes: int) -> Floats:
    spread: Floats = maximum_filter1d(raster, 2 * nodes + 1, axis=axis, mode="nearest")
    return spread


def _moved(raster: Floats, axis: int, cells: float) -> Floats:
    """Return the raster read ``cells`` farther along an axis, linear between nodes."""
    before = math.floor(cells)
    share = cells - before
    index = np.arange(raster.shape[axis])
    last = raster.shape[axis] - 1
    low = np.take(raster, np.clip(index + before, 0, last), axis=axis)
    if share == 0:
        return low
    return (1 - share) * low + share * np.take(
        raster, np.clip(index + before + 1, 0, last), axis=axis
    )
