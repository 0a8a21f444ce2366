"""The clearance required over the surface, and the raised rasters that planners search above.

Less clearance is required near start and goal, because otherwise no aircraft could take off or
land: see :class:`Demand`.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.aircraft import Aircraft
from pathgene.host.problem.ends import Point
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.surroundings import around
from pathgene.host.problem.zone_raster import Part, blocked_cells
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.surface import ANY_VOID_M, VOID_M


if TYPE_CHECKING:
    from pathgene.host.problem.compiled.floors import EndDemand, NearEnd

__all__ = ["Demand", "SearchRasters"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Cells around an end in which the rasters are lowered so that the aircraft can climb from the end.
_CELLS_AT_ENDS = 4.0
# Slope of that climb, as a share of the steepest one.
_SHARE_OF_CLIMB = 0.9
# The rasters lie this far below the ends, so that rounding does not enclose the ends.
_BELOW_ENDS_M = 0.005
# A square that ends this far beyond the corridor from the edge of the map is not in it, metres.
_EDGE_M = 1e-6


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
        # Loads numba, which compiles the kernel.
        from pathgene.host.problem.compiled.surfaces import surfaces_below

        below = surfaces_below(terrain, np.ascontiguousarray(ends[:, :2].T), math.inf)
        surroundings = around(terrain, rules.corridor_m)
        beside = np.array(
            [
                surroundings.highest_within(terrain, x, y, z - rules.clearance_m)
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

    def packed(self) -> tuple[EndDemand, EndDemand]:
        """Return the demand of both ends, as the kernels take it."""
        # Loads numba.
        from pathgene.host.problem.compiled.floors import EndDemand

        start, goal = (
            EndDemand(*end, height, beside, slope)
            for end, height, beside, slope in zip(
                self.ends, self.heights_m, self.heights_beside_m, self.slopes, strict=True
            )
        )
        return start, goal


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
    part : (slice, slice), optional
        Rows and columns of the rasters, all by default: the same numbers as in the whole rasters.

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
        part: Part | None = None,
    ) -> None:
        if part is None:
            part = slice(0, terrain.shape[0]), slice(0, terrain.shape[1])
        self.floor = _floor(terrain, demand, rules.corridor_m, part)
        roof: Floats | None = None
        if rules.ceiling_agl_m is not None:
            # The surface in a node's square is nowhere below the node.
            ground = terrain.elevation[part]
            roof = np.where(np.isnan(ground), np.inf, ground + rules.ceiling_agl_m)
        # All zones without heights and times at once: there may be thousands.
        plain = [zone for zone in zones if not _is_limited(zone)]
        limited = [zone for zone in zones if _is_limited(zone)]
        self.nofly = blocked_cells(plain, terrain, rules.zone_margin_m, part)
        self.at_times = np.zeros(self.nofly.shape, dtype=bool)
        at_times = []
        start = demand.ends[0]
        for zone in limited:
            if zone.t1_s is not None:
                reach_m = fastest_m_s * zone.t1_s + rules.zone_margin_m
                if zone.footprint.least_distance_m(start[0], start[1]) > reach_m:
                    continue
            cells = blocked_cells([zone], terrain, rules.zone_margin_m, part)
            if zone.lower_m is not None:
                lowest = zone.lower_m - rules.zone_margin_m
                under = cells & (self.floor + rules.clearance_m <= lowest)
                roof = np.full(cells.shape, np.inf) if roof is None else roof
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


def _is_limited(zone: Zone) -> bool:
    """Return whether a zone has limits of height or time."""
    limits = (zone.lower_m, zone.upper_m, zone.t0_s, zone.t1_s)
    return zone.follows_ground or any(limit is not None for limit in limits)


def _floor(terrain: Terrain, demand: Demand, corridor_m: float, part: Part) -> Floats:
    """Return the surface around each node plus the required clearance, NaN near voids."""
    highest = around(terrain, corridor_m).nodes(terrain)[part]
    floor = highest + demand.clearance_m
    half_diagonal = 0.5 * math.hypot(terrain.dx_m, terrain.dy_m)
    # Less is required only near the ends.
    windows = [
        _Window(terrain, at, reach + 2 * half_diagonal, part)
        for at, reach in zip(demand.ends, _reaches_m(demand, half_diagonal), strict=True)
    ]
    # A part of the map seldom reaches an end.
    near_ends = [
        (number, window.near_end(demand.clearance_m, half_diagonal))
        for number, window in enumerate(windows)
        if not window.is_empty
    ]
    if near_ends:
        # Loads numba, which compiles the kernels.
        from pathgene.host.problem.compiled import floors

        ends = demand.packed()
        for _, near in near_ends:
            floors.require_near_end(floor, highest, near, *ends)
        # At the ends a node requires no more than the aircraft can climb from there.
        for number, near in near_ends:
            end = ends[number]
            # The raster requires more than the rule where the ground rises from node to node.
            missing_m = max(demand.clearance_m - end.beside_m, 0.0) + demand.clearance_m
            around_m = _CELLS_AT_ENDS * half_diagonal
            ramp = (
                around_m + missing_m / end.slope,
                around_m,
                _SHARE_OF_CLIMB * 2.0 * end.slope,
                end.altitude_m - _BELOW_ENDS_M,
            )
            floors.ease_near_end(floor, terrain.elevation, near, ends, number, ramp)
    floor[floor > ANY_VOID_M] = np.nan
    if corridor_m > 0:
        _block_edges(floor, terrain, demand.ends, corridor_m, part)
    return floor


def _block_edges(
    floor: Floats, terrain: Terrain, ends: tuple[Point, Point], corridor_m: float, part: Part
) -> None:
    """Write NaN to the nodes with a point in their square whose corridor leaves the map.

    Around an end, a node keeps its floor unless its square and half a cell beyond it are nearer to
    an edge than the end and the corridor. Half a cell, because the chip looks at the four nodes
    around a corner, and one of them may lie between the end and the edge.
    """
    depths = [
        math.ceil((corridor_m - _EDGE_M) / side + 0.5) for side in (terrain.dy_m, terrain.dx_m)
    ]
    bands = [
        (max(depth - places.start, 0), max(count - depth - places.start, 0))
        for depth, places, count in zip(depths, part, terrain.shape, strict=True)
    ]
    (south, north), (west, east) = bands
    if not (south or west or north < floor.shape[0] or east < floor.shape[1]):
        return
    half_diagonal = 0.5 * math.hypot(terrain.dx_m, terrain.dy_m)
    kept = []
    for x, y, _ in ends:
        # Distances from the west, east, south and north.
        away = (x, terrain.width_m - x, y, terrain.height_m - y)
        reach_m = (_CELLS_AT_ENDS + 1) * half_diagonal + max(corridor_m - min(away), 0.0)
        window = _Window(terrain, (x, y, 0.0), reach_m, part)
        at_x, at_y = window.x, window.y
        near = np.hypot(at_x - x, at_y - y) <= reach_m
        for places, side, end_m in (
            (at_x, terrain.dx_m, away[0]),
            (terrain.width_m - at_x, terrain.dx_m, away[1]),
            (at_y, terrain.dy_m, away[2]),
            (terrain.height_m - at_y, terrain.dy_m, away[3]),
        ):
            near &= places + side > min(end_m, corridor_m)
        kept.append((window.here, near, floor[window.here].copy()))
    floor[:south] = floor[north:] = floor[:, :west] = floor[:, east:] = np.nan
    for here, near, heights in kept:
        floor[here] = np.where(near, heights, floor[here])


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


class _Window:
    """The nodes of a part of the rasters within a distance of a point in both axes.

    Attributes
    ----------
    nodes : (slice, slice)
        Their rows and columns.
    here : (slice, slice)
        The same in the part.
    """

    def __init__(self, terrain: Terrain, at: Point, reach_m: float, part: Part) -> None:
        self._terrain = terrain
        rows, columns = (
            _within(middle, reach_m, side, places)
            for middle, side, places in (
                (at[1], terrain.dy_m, part[0]),
                (at[0], terrain.dx_m, part[1]),
            )
        )
        self.nodes = rows, columns
        self.here = (_moved_to(part[0], rows), _moved_to(part[1], columns))

    @property
    def is_empty(self) -> bool:
        """True if the part has no such node."""
        return any(nodes.start >= nodes.stop for nodes in self.nodes)

    def near_end(self, clearance_m: float, half_diagonal_m: float) -> NearEnd:
        """Return the nodes as the kernels take them."""
        # Loads numba.
        from pathgene.host.problem.compiled.floors import NearEnd

        (rows, columns), terrain = self.nodes, self._terrain
        return NearEnd(
            rows.start,
            rows.stop,
            columns.start,
            columns.stop,
            rows.start - self.here[0].start,
            columns.start - self.here[1].start,
            terrain.dx_m,
            terrain.dy_m,
            clearance_m,
            half_diagonal_m,
            VOID_M,
            ANY_VOID_M,
        )

    @property
    def x(self) -> Floats:
        """Place of the columns, (1, n), metres."""
        columns = self.nodes[1]
        return np.arange(columns.start, columns.stop, dtype=np.float64)[None] * self._terrain.dx_m

    @property
    def y(self) -> Floats:
        """Place of the rows, (m, 1), metres."""
        rows = self.nodes[0]
        return np.arange(rows.start, rows.stop, dtype=np.float64)[:, None] * self._terrain.dy_m


def _within(middle: float, reach_m: float, side: float, places: slice) -> slice:
    """Return the nodes of an axis within a distance of ``middle``, among ``places``."""
    first = max(math.floor((middle - reach_m) / side), places.start)
    last = min(math.ceil((middle + reach_m) / side) + 1, places.stop)
    return slice(first, max(last, first))


def _moved_to(places: slice, nodes: slice) -> slice:
    """Return ``nodes`` counted from the first of ``places``."""
    return slice(nodes.start - places.start, nodes.stop - places.start)
