"""The clearance required over the surface, and the raised rasters that planners search above.

Less clearance is required near start and goal, because otherwise no aircraft could take off or
land: see :class:`Demand`.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.ends import Point
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zone_raster import blocked_cells
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.surface import ANY_VOID_M, VOID_M, surface_below


__all__ = ["Demand", "SearchRasters"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Cells around an end in which the rasters are lowered so that the aircraft can climb from the end.
_CELLS_AT_ENDS = 4.0
# Slope of that climb, as a share of the steepest one.
_SHARE_OF_CLIMB = 0.9
# The rasters lie this far below the ends, so that rounding does not enclose the ends.
_BELOW_ENDS_M = 0.005
# Places on the rim of the corridor around an end, and metres by which they may miss the highest
# surface there.
_RIM_PLACES = 3600
_RIM_SLACK_M = 1e-3
# A square that ends this far beyond the corridor from the edge of the map is not in it, metres.
_EDGE_M = 1e-6
# Number of places of a terrain whose surroundings are cached.
_MOST_PLACES = 64


@dataclass(frozen=True)
class Demand:
    """The clearance required at a horizontal distance from both ends.

    It is the minimum of the rule's clearance and, for each end, the end's own height over the
    surface plus half the tangent of the climb limit (the descent limit at the goal) times the
    distance. Over the surface right below the track, that is the end's height over the surface
    below it; to the side of the track, its height over the highest surface within the corridor.

    Parameters
    ----------
    clearance_m : float
        Clearance of the rule.
    heights_m : (float, float)
        Height of start and goal over the surface below.
    heights_beside_m : (float, float)
        Height over the highest surface on the map within the corridor around the end, but at least
        minus the corridor's width, because a cliff next to an end does not excuse the path. If it
        exceeds the clearance, it may be computed for a wider corridor.
    slopes : (float, float)
        Growth of the required clearance with distance from start and goal.
    ends : ((float, float, float), (float, float, float))
        Start and goal.
    """

    clearance_m: float
    heights_m: tuple[float, float]
    heights_beside_m: tuple[float, float]
    slopes: tuple[float, float]
    ends: tuple[Point, Point]

    @staticmethod
    def of(terrain: Terrain, start: Point, goal: Point, aircraft: Aircraft, rules: Rules) -> Demand:
        """Return the required clearance of a flight."""
        ends = np.array([start, goal])
        below = surface_below(terrain, ends[:, 0], ends[:, 1])
        around = _around(terrain, rules.corridor_m)
        beside = np.array(
            [
                around.highest_within(terrain, x, y, z - rules.clearance_m)
                for x, y, z in ends.tolist()
            ]
        )
        # An end next to a void is itself too low, but that does not excuse the path.
        heights, heights_beside = (
            np.where(np.isfinite(surface), ends[:, 2] - surface, 0.0)
            for surface in (below, np.maximum(below, beside))
        )
        return Demand(
            rules.clearance_m,
            (float(heights[0]), float(heights[1])),
            tuple(np.maximum(heights_beside, -rules.corridor_m).tolist()),
            (
                0.5 * math.tan(math.radians(aircraft.max_climb_deg)),
                0.5 * math.tan(math.radians(aircraft.max_descent_deg)),
            ),
            (start, goal),
        )

    def required_m(
        self, x: Floats, y: Floats, nearer_m: float = 0.0, *, beside: bool = False
    ) -> Floats:
        """Return the clearance required at points, as if ``nearer_m`` closer to both ends.

        It applies to the surface right below the track or, with ``beside``, in the corridor.
        """
        required = np.full(np.broadcast(x, y).shape, self.clearance_m)
        heights = self.heights_beside_m if beside else self.heights_m
        for height, slope, (at_x, at_y, _) in zip(heights, self.slopes, self.ends, strict=True):
            away = np.maximum(np.hypot(x - at_x, y - at_y) - nearer_m, 0.0)
            required = np.minimum(required, height + slope * away)
        return required


def _highest_within(terrain: Terrain, x: float, y: float, radius_m: float) -> float:
    """Return the highest surface within a distance of a point, metres; infinite near a void.

    The maximum lies at a node, on the rim, or where the rim crosses a line of nodes or of the
    squares around them. A millimetre is added because the rim is sampled.
    """
    if radius_m == 0:
        return float(surface_below(terrain, np.array([x]), np.array([y]))[0])
    angles = [np.linspace(0.0, 2 * math.pi, _RIM_PLACES, endpoint=False)]
    for at, side, shift in ((x, terrain.dx_m, 0.0), (y, terrain.dy_m, 0.5 * math.pi)):
        lines = (
            0.5
            * side
            * np.arange(
                math.ceil(2 * (at - radius_m) / side), math.floor(2 * (at + radius_m) / side) + 1
            )
        )
        turn = np.arccos(np.clip((lines - at) / radius_m, -1, 1))
        angles += [shift + turn, shift - turn]
    around = np.concatenate(angles)
    # Both sides of a border between two squares.
    rim = (radius_m + np.array([[-1e-6], [0.0], [1e-6]])) * np.stack(
        (np.cos(around), np.sin(around))
    )[:, None]
    highest = surface_below(terrain, x + rim[0].ravel(), y + rim[1].ravel()).max()
    # Nodes whose squares the circle touches.
    rows, columns = terrain.shape
    across = np.arange(columns) * terrain.dx_m
    up = np.arange(rows) * terrain.dy_m
    away_x = np.maximum(np.abs(across - x) - 0.5 * terrain.dx_m, 0.0)
    away_y = np.maximum(np.abs(up - y) - 0.5 * terrain.dy_m, 0.0)
    touched = np.hypot(away_x[None, :], away_y[:, None]) <= radius_m
    nodes = np.where(np.isnan(terrain.elevation), np.inf, terrain.elevation)[touched]
    return float(max(highest, nodes.max(initial=-np.inf))) + _RIM_SLACK_M


class SearchRasters:
    """Rasters with the terrain's shape; a sampled path above them nearly always keeps the rules.

    The strict rule decides on each path; these rasters let planners search as if there were no
    rules. A node stands for its cell square.

    Parameters
    ----------
    terrain : Terrain
        The ground.
    demand : Demand
        Required clearance.
    zones : iterable of Zone
        No-fly zones; a zone that ends before it can be reached is left out.
    rules : Rules
        Corridor, margin of zones and ceiling above ground.
    fastest_m_s : float
        Maximum possible ground speed.

    Attributes
    ----------
    floor : (ny, nx) float64, metres
        Minimum altitude at each node: the highest surface within the corridor of any point of the
        square, plus the required clearance, and zones to be flown over; NaN over voids and near
        them, and if the corridor of any point of the square leaves the map. Around an end that is
        near the edge of the map, fewer nodes are NaN, so that paths can leave the end.
    roof : (ny, nx) float64, metres, or None
        Maximum altitude at each node: the ceiling above ground, and zones to be flown under;
        infinite if it is not limited. None if no node is limited.
    nofly : (ny, nx) bool
        Nodes in zones that can be flown neither over nor under.
    at_times : (ny, nx) bool
        Nodes in such zones that are only active at times.
    at_times_zones : tuple of Zone
        These zones.
    """

    def __init__(
        self,
        terrain: Terrain,
        demand: Demand,
        zones: Collection[Zone],
        rules: Rules,
        fastest_m_s: float,
    ) -> None:
        self.floor = _floor(terrain, demand, rules.corridor_m)
        roof: Floats | None = None
        if rules.ceiling_agl_m is not None:
            # The surface in a node's square is nowhere below the node.
            roof = np.where(terrain.voids, np.inf, terrain.elevation + rules.ceiling_agl_m)
        # All zones without heights and times at once: there may be thousands.
        plain = [zone for zone in zones if not zone.limits.keys() - {"name"}]
        limited = [zone for zone in zones if zone.limits.keys() - {"name"}]
        self.nofly = blocked_cells(plain, terrain, rules.zone_margin_m)
        self.at_times = np.zeros(terrain.shape, dtype=bool)
        at_times = []
        start = demand.ends[0]
        for zone in limited:
            if zone.t1_s is not None:
                reach_m = fastest_m_s * zone.t1_s + rules.zone_margin_m
                if zone.footprint.least_distance_m(start[0], start[1]) > reach_m:
                    continue
            cells = blocked_cells([zone], terrain, rules.zone_margin_m)
            if zone.lower_m is not None:
                lowest = zone.lower_m - rules.zone_margin_m
                under = cells & (self.floor + rules.clearance_m <= lowest)
                roof = np.full(terrain.shape, np.inf) if roof is None else roof
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
        self.roof = roof if roof is not None and np.isfinite(roof).any() else None


def _floor(
    terrain: Terrain,
    demand: Demand,
    corridor_m: float,
) -> Floats:
    """Return the surface around each node plus the required clearance, NaN near voids."""
    highest = _around(terrain, corridor_m).nodes
    floor = highest + demand.clearance_m
    half_diagonal = 0.5 * math.hypot(terrain.dx_m, terrain.dy_m)
    # Less is required only near the ends.
    windows = [
        _window(terrain, at, reach + 2 * half_diagonal)
        for at, reach in zip(demand.ends, _reaches_m(demand, half_diagonal), strict=True)
    ]
    for rows, columns in windows:
        x, y = _places(terrain, rows, columns)
        required = demand.required_m(x, y, -half_diagonal, beside=True)
        floor[rows, columns] = highest[rows, columns] + required
    # At the ends a node requires no more than the aircraft can climb from there.
    for (rows, columns), (at_x, at_y, z), slope, height in zip(
        windows, demand.ends, demand.slopes, demand.heights_beside_m, strict=True
    ):
        x, y = _places(terrain, rows, columns)
        there = floor[rows, columns]
        away = np.maximum(np.hypot(x - at_x, y - at_y) - half_diagonal, 0.0)
        # The raster requires more than the rule where the ground rises from node to node.
        ramp_m = (max(demand.clearance_m - height, 0.0) + demand.clearance_m) / slope
        near = away <= _CELLS_AT_ENDS * half_diagonal + ramp_m
        heights = terrain.elevation[rows, columns]
        least = np.where(np.isnan(heights), VOID_M, heights)
        least = least + demand.required_m(x, y, half_diagonal)
        steepest = _SHARE_OF_CLIMB * 2.0 * slope
        eased = np.maximum(least, np.minimum(there, z + steepest * away))
        eased = np.minimum(eased, np.where(away == 0, z - _BELOW_ENDS_M, np.inf))
        # Nodes near a void are not lowered, unless the end itself is next to the void.
        near &= (there < ANY_VOID_M) | (away <= _CELLS_AT_ENDS * half_diagonal)
        floor[rows, columns] = np.where(near, eased, there)
    floor = np.where(floor > ANY_VOID_M, np.nan, floor)
    if corridor_m > 0:
        _block_edges(floor, terrain, demand.ends, corridor_m)
    return floor


def _block_edges(
    floor: Floats, terrain: Terrain, ends: tuple[Point, Point], corridor_m: float
) -> None:
    """Write NaN to the nodes with a point in their square whose corridor leaves the map.

    Around an end, a node keeps its floor unless its square and half a cell beyond it are nearer to
    an edge than the end and the corridor. Half a cell, because the chip looks at the four nodes
    around a corner, and one of them may lie between the end and the edge.
    """
    half_diagonal = 0.5 * math.hypot(terrain.dx_m, terrain.dy_m)
    kept = []
    for x, y, _ in ends:
        # Distances from the west, east, south and north.
        away = (x, terrain.width_m - x, y, terrain.height_m - y)
        reach_m = (_CELLS_AT_ENDS + 1) * half_diagonal + max(corridor_m - min(away), 0.0)
        window = _window(terrain, (x, y, 0.0), reach_m)
        at_x, at_y = _places(terrain, *window)
        near = np.hypot(at_x - x, at_y - y) <= reach_m
        for places, side, end_m in (
            (at_x, terrain.dx_m, away[0]),
            (terrain.width_m - at_x, terrain.dx_m, away[1]),
            (at_y, terrain.dy_m, away[2]),
            (terrain.height_m - at_y, terrain.dy_m, away[3]),
        ):
            near &= places + side > min(end_m, corridor_m)
        kept.append((window, near, floor[window].copy()))
    rows, columns = (
        math.ceil((corridor_m - _EDGE_M) / side + 0.5) for side in (terrain.dy_m, terrain.dx_m)
    )
    floor[:rows] = floor[-rows:] = floor[:, :columns] = floor[:, -columns:] = np.nan
    for window, near, heights in kept:
        floor[window] = np.where(near, heights, floor[window])


def _reaches_m(demand: Demand, half_diagonal: float) -> tuple[float, float]:
    """Return the distances from start and goal beyond which the ends have no influence."""
    start, goal = (
        max(_CELLS_AT_ENDS * half_diagonal, 2 * half_diagonal)
        + (max(demand.clearance_m - height, 0.0) + demand.clearance_m) / slope
        for height, slope in zip(
            np.minimum(demand.heights_m, demand.heights_beside_m).tolist(),
            demand.slopes,
            strict=True,
        )
    )
    return start, goal


def _window(terrain: Terrain, at: Point, reach_m: float) -> tuple[slice, slice]:
    """Return rows and columns of the nodes within a distance of a point in both axes."""
    (rows, columns), (x, y, _) = terrain.shape, at
    south, west = (
        max(math.floor((middle - reach_m) / side), 0)
        for middle, side in ((y, terrain.dy_m), (x, terrain.dx_m))
    )
    north, east = (
        min(math.ceil((middle + reach_m) / side) + 1, count)
        for middle, side, count in ((y, terrain.dy_m, rows), (x, terrain.dx_m, columns))
    )
    return slice(south, north), slice(west, east)


def _places(terrain: Terrain, rows: slice, columns: slice) -> tuple[Floats, Floats]:
    """Return x of the columns, (1, n), and y of the rows, (m, 1), metres."""
    x = np.arange(columns.start, columns.stop, dtype=np.float64)[None, :] * terrain.dx_m
    y = np.arange(rows.start, rows.stop, dtype=np.float64)[:, None] * terrain.dy_m
    return x, y


class _Around:
    """The highest surface around places of a terrain, cached because changed problems ask again.

    Parameters
    ----------
    terrain : Terrain
        The ground.
    corridor_m : float
        Distance within which the surface counts.

    Attributes
    ----------
    nodes : (ny, nx) float64, metres
        See :func:`_highest_around`; do not write to it.
    """

    def __init__(self, terrain: Terrain, corridor_m: float) -> None:
        self.corridor_m = corridor_m
        # Without a reference to the terrain, which is the weak key of this object.
        heights = np.where(terrain.voids, VOID_M, terrain.elevation)
        self.nodes = _highest_around(heights, terrain, corridor_m)
        self._within: dict[tuple[float, float], float] = {}

    def highest_within(self, terrain: Terrain, x: float, y: float, enough_m: float) -> float:
        """Return the highest surface around a point, metres; infinite near a void.

        If no surface around the nearest node's square is above ``enough_m``, its highest is
        returned.
        """
        nearest = float(self.nodes[terrain.nearest_nodes(x, y)])
        if nearest <= enough_m:
            return nearest
        if (x, y) not in self._within:
            if len(self._within) >= _MOST_PLACES:
                self._within.clear()
            self._within[x, y] = _highest_within(terrain, x, y, self.corridor_m)
        return self._within[x, y]


# The surroundings for the latest corridor of each terrain.
_AROUND: WeakKeyDictionary[Terrain, _Around] = WeakKeyDictionary()


def _around(terrain: Terrain, corridor_m: float) -> _Around:
    known = _AROUND.get(terrain)
    if known is None or known.corridor_m != corridor_m:
        known = _AROUND[terrain] = _Around(terrain, corridor_m)
    return known


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
    """Return the maximum within ``nodes`` of each node along an axis; SciPy takes 0.3 s to load."""
    spread = raster.copy()
    highest = np.moveaxis(spread, axis, 0)
    nodes = min(nodes, len(highest) - 1)
    within = 0
    while within < nodes:
        # The windows around nodes this far away touch the window around the node.
        step = min(2 * within + 1, nodes - within)
        near = highest.copy()
        np.maximum(highest[step:], near[:-step], out=highest[step:])
        np.maximum(highest[:-step], near[step:], out=highest[:-step])
        np.maximum(highest[:step], near[0], out=highest[:step])
        np.maximum(highest[-step:], near[-1], out=highest[-step:])
        within += step
    return spread


def _moved(raster: Floats, axis: int, cells: float) -> Floats:
    """Return the raster shifted by ``cells`` along an axis, linear between nodes."""
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
