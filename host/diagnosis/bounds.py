"""Bounds that every path keeps: places and altitudes that are forbidden beyond doubt.

Bounds err on the side of caution. A place is forbidden only if the strict rule forbids it whatever
the path; so no path exists if the bounds leave no route.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from pathgene.host.diagnosis.barriers import Barrier
from pathgene.host.problem.limits import slope_of_thrust
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import numbers_of
from pathgene.host.problem.zone_raster import blocked_cells
from pathgene.host.problem.zones import Zone


__all__ = ["Bounds", "is_permanent", "zone_name"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

_EIGHT = np.ones((3, 3), dtype=bool)
# Smaller differences of altitude are rounding.
_ROUNDING_M = 1e-6


def is_permanent(zone: Zone) -> bool:
    """Return whether a zone is active from the start of every path to its end."""
    return zone.t0_s in (None, 0.0) and zone.t1_s is None


def zone_name(problem: Problem, index: int) -> str:
    """Return the name of a zone in sentences; nameless ones are numbered from 1."""
    return f"zone {problem.zones[index].name or numbers_of(problem.zones)[index]}"


class Bounds:
    """Places and altitudes of one problem that are certainly forbidden.

    Parameters
    ----------
    problem : Problem
        The problem, with rules or with ``as_paper``.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.half_diagonal_m = 0.5 * math.hypot(problem.terrain.dx_m, problem.terrain.dy_m)

    @property
    def margin_m(self) -> float:
        """Margin of zones; 0 with ``as_paper``."""
        return 0.0 if self.problem.rules is None else self.problem.rules.zone_margin_m

    @cached_property
    def edges_m(self) -> tuple[float, float, float, float]:
        """Widths of the strips along the west, east, south and north edges that no path can enter.

        A track is parallel to an edge at its place nearest to the edge, unless this is an end of
        the track. So a strip is as wide as the corridor if both ends are at least that far from the
        edge, and 0 otherwise.
        """
        problem, terrain = self.problem, self.problem.terrain
        corridor_m = 0.0 if problem.rules is None else problem.rules.corridor_m
        x, y, _ = np.array([problem.start, problem.goal]).T
        west, east, south, north = (
            corridor_m if away.min() >= corridor_m else 0.0
            for away in (x, terrain.width_m - x, y, terrain.height_m - y)
        )
        return west, east, south, north

    @cached_property
    def lowest(self) -> Floats:
        """Minimum altitude of any path in the square of each node; infinite over voids."""
        terrain = self.problem.terrain
        heights = np.where(terrain.voids, np.inf, terrain.elevation)
        if self.problem.rules is None:
            return heights
        rows, columns = terrain.shape
        x: Floats = np.arange(columns, dtype=np.float64)[None, :] * terrain.dx_m
        y: Floats = np.arange(rows, dtype=np.float64)[:, None] * terrain.dy_m
        least: Floats = heights + self.problem.demand.required_m(x, y, self.half_diagonal_m)
        return least

    def barrier(self, top_m: float = math.inf, agl_m: float = math.inf) -> Barrier:
        """Return the barrier below a ceiling, and below a ceiling above ground."""
        problem, terrain = self.problem, self.problem.terrain
        forbidden = self.lowest > top_m + _ROUNDING_M if top_m < math.inf else terrain.voids.copy()
        if problem.rules is None:
            # The samples of a path may slip between two nodes that touch at a corner.
            return Barrier(
                terrain,
                problem.start,
                problem.goal,
                forbidden | problem.nofly_raster,
                np.empty((0, 5)),
                np.empty(0, dtype=np.int64),
                diagonal=False,
            )
        pieces, owners = [np.empty((0, 5))], [np.empty(0, dtype=np.int64)]
        for index, zone in enumerate(problem.zones):
            if not is_permanent(zone):
                continue
            if self._closes(zone, top_m, agl_m):
                own = zone.footprint.capsules(self.margin_m)
                pieces.append(own)
                owners.append(np.full(len(own), index))
            else:
                forbidden |= self._closed_nodes(zone, top_m)
        return Barrier(
            terrain,
            problem.start,
            problem.goal,
            forbidden,
            np.concatenate(pieces),
            np.concatenate(owners),
            edges_m=self.edges_m,
        )

    def closing_zones(self, top_m: float = math.inf, agl_m: float = math.inf) -> tuple[int, ...]:
        """Return the zones that no path can fly over or under."""
        return tuple(
            index
            for index, zone in enumerate(self.problem.zones)
            if is_permanent(zone) and self._closes(zone, top_m, agl_m)
        )

    def _closes(self, zone: Zone, top_m: float, agl_m: float) -> bool:
        """Return whether no path can fly over or under a zone anywhere."""
        cells = self.cells(zone)
        if zone.upper_m is not None:
            least = zone.upper_m + self.margin_m
            around = ndimage.binary_dilation(cells, _EIGHT)
            heights = self.problem.terrain.elevation[around & ~self.problem.terrain.voids]
            roof = min(top_m, float(heights.max()) + agl_m if len(heights) else top_m)
            if least <= roof + _ROUNDING_M:
                return False
        if zone.lower_m is not None:
            lowest = self.lowest[cells]
            if len(lowest) and lowest.min() <= zone.lower_m - self.margin_m + _ROUNDING_M:
                return False
        return True

    def _closed_nodes(self, zone: Zone, top_m: float) -> Flags:
        """Return the nodes whose square is inside a zone, with no room above or below the zone."""
        none = np.zeros(self.problem.terrain.shape, dtype=bool)
        if zone.lower_m is None or len(zone.footprint.rings) > 1:
            return none
        if zone.upper_m is not None and zone.upper_m + self.margin_m <= top_m + _ROUNDING_M:
            return none
        terrain = self.problem.terrain
        rows, columns = terrain.shape
        x: Floats = np.arange(columns, dtype=np.float64) * terrain.dx_m
        y: Floats = np.arange(rows, dtype=np.float64) * terrain.dy_m
        nodes = zone.covers(x, y)
        inside: Flags = ndimage.binary_erosion(nodes, _EIGHT, border_value=1)
        return inside & (self.lowest > zone.lower_m - self.margin_m + _ROUNDING_M)

    def cells(self, zone: Zone) -> Flags:
        """Return the nodes whose cell meets a zone or its margin."""
        return blocked_cells([zone], self.problem.terrain, self.margin_m)

    @cached_property
    def climb_slope(self) -> float:
        """Tangent of the steepest allowed climb over the ground in any direction."""
        return self._steepest(self.problem.aircraft.max_climb_deg)

    @cached_property
    def descent_slope(self) -> float:
        """Tangent of the steepest descent over the ground in any direction."""
        return self._steepest(self.problem.aircraft.max_descent_deg)

    @cached_property
    def power_slope(self) -> float:
        """Tangent of the steepest climb that the engine can hold at the minimum weight."""
        problem, aircraft = self.problem, self.problem.aircraft
        thrust = problem.limits.thrust_N
        if thrust == math.inf or not problem.limits.fuel_N < math.inf:
            return math.inf
        _, high = slope_of_thrust(aircraft, thrust, aircraft.weight_N - problem.limits.fuel_N)
        return math.tan(high) if high < 0.5 * math.pi - 1e-9 else math.inf

    def _steepest(self, degrees: float) -> float:
        """Return the tangent of a slope over the ground, flown against the wind: its steepest."""
        slope = math.radians(degrees)
        if degrees >= 90:
            return math.inf
        speed = self.problem.aircraft.cruise_speed_m_s
        wind = 0.0 if self.problem.rules is None else math.hypot(*self.problem.wind)
        level = speed * math.cos(slope) - wind
        return math.inf if level <= 0 else speed * math.sin(slope) / level
