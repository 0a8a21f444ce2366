"""A planning problem: start, goal, aircraft, terrain, zones and rules."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.numeric import real
from pathgene.host.problem.aircraft import DEFAULT, Aircraft, load
from pathgene.host.problem.ends import Point, check_above_ground, end_point, finite
from pathgene.host.problem.limits import Limits, slope_limits
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.tiles import over_ground
from pathgene.host.problem.zones import Zone, listed, raster
from pathgene.host.remarks import Reading
from pathgene.host.terrain import Terrain


if TYPE_CHECKING:
    from pathgene.host.problem.surface import Demand, SearchRasters

__all__ = ["SMALLEST_DS_M", "Problem"]

SMALLEST_DS_M = 1e-3
# Maximum samples along the way: at an eighth of the step, a track has ten times as many.
_MOST_SAMPLES = 500_000
# No point outside a zone's box by more is in the zone, whatever the rounding.
_NEAR_M = 1.0
_SAFE = Rules()
_NOT_READ = Reading({"files": []})


@dataclass(frozen=True, eq=False, init=False)
class Problem:
    """A flight to plan: terrain, both ends, the aircraft, the zones to avoid and the wind.

    Positions are metres in the terrain's local frame: x to the east, y to the north, from the
    south-west node. Altitudes are metres above the terrain's datum.

    Parameters
    ----------
    terrain : Terrain
        The ground; NaN is a void.
    start, goal : (float, float, float)
        x, y and altitude. Different points inside the map (the rectangle of its nodes), not below
        the ground, not over a void, not in a no-fly zone.
    aircraft : Aircraft, str or Path
        The aircraft, the name of a shipped one, or the TOML file of one. The attribute has the true
        airspeed and the turn at the mean altitude of start and goal.
    zones : iterable of Zone
        No-fly zones. The attribute has the tiles of zones with limits above the ground; see
        :func:`pathgene.host.problem.tiles.wholes`.
    wind : (float, float)
        Constant wind in m/s towards true east and true north; slower than the aircraft.
    ds_m : float, optional
        Sampling step of the distances under the terrain and in no-fly zones; by default half the
        smaller side of a cell; at least a millimetre, and at most the straight distance from start
        to goal.
    agl : bool
        The third numbers of ``start`` and ``goal`` are heights above the ground, not altitudes.
    geo : bool
        The first two numbers of ``start`` and ``goal`` are WGS84 latitude and longitude in degrees;
        the terrain must have a coordinate reference system.
    rules : Rules or None
        Rules that a path must keep in addition to the evaluation of the papers, by default
        :class:`Rules` without arguments. None means ``as_paper``.
    as_paper : bool
        No rules: only the evaluation of the papers. It excludes rules and headings.
    start_heading_deg, goal_heading_deg : float, optional
        Heading at start and goal, degrees clockwise from true north, -360 to 360. The turn
        between the heading and the adjacent segment is an arc like any other.
    zones_reading : Reading
        Facts that were read from files of zones, and remarks on them.

    Raises
    ------
    InputError
        If a value is outside the range above.
    """

    terrain: Terrain
    start: Point
    goal: Point
    aircraft: Aircraft
    zones: tuple[Zone, ...]
    wind: tuple[float, float]
    ds_m: float
    rules: Rules | None
    start_heading_deg: float | None
    goal_heading_deg: float | None
    zones_reading: Reading

    def __init__(
        self,
        terrain: Terrain,
        start: Sequence[float],
        goal: Sequence[float],
        aircraft: Aircraft | str | Path = DEFAULT,
        zones: Iterable[Zone] = (),
        wind: Sequence[float] = (0.0, 0.0),
        ds_m: float | None = None,
        *,
        agl: bool = False,
        geo: bool = False,
        rules: Rules | None = _SAFE,
        as_paper: bool = False,
        start_heading_deg: float | None = None,
        goal_heading_deg: float | None = None,
        zones_reading: Reading = _NOT_READ,
    ) -> None:
        if not isinstance(terrain, Terrain):
            raise InputError(
                f"The terrain must be a Terrain, not of the type {type(terrain).__name__}; "
                "make one with Terrain.load."
            )
        if as_paper and not (start_heading_deg is None and goal_heading_deg is None):
            raise InputError(
                "The evaluation of the papers knows no headings; leave them out, or --as-paper."
            )
        rules = _rules(rules, as_paper)
        if rules is None:
            terrain = terrain.on_paper
        half_a_cell_m = 0.5 * min(terrain.dx_m, terrain.dy_m)
        aircraft = aircraft if isinstance(aircraft, Aircraft) else load(aircraft)
        ends = (
            end_point("start", start, terrain, agl=agl, geo=geo),
            end_point("goal", goal, terrain, agl=agl, geo=geo),
        )
        for name, value in {
            "terrain": terrain,
            "start": ends[0],
            "goal": ends[1],
            "aircraft": aircraft.at(0.5 * (ends[0][2] + ends[1][2])),
            "zones": over_ground(listed(zones), terrain),
            "wind": finite("wind", wind, 2),
            "ds_m": half_a_cell_m if ds_m is None else real("sampling step", ds_m),
            "rules": rules,
            "start_heading_deg": _heading("start", start_heading_deg),
            "goal_heading_deg": _heading("goal", goal_heading_deg),
            "zones_reading": zones_reading,
        }.items():
            object.__setattr__(self, name, value)
        self._check(half_a_cell_m)

    def _check(self, half_a_cell_m: float) -> None:
        if not (math.isfinite(self.ds_m) and self.ds_m > 0):
            raise InputError(
                f"The sampling step must be a positive number of metres, not {self.ds_m:g}."
            )
        if self.ds_m < SMALLEST_DS_M:
            raise InputError(
                f"The sampling step must be at least {SMALLEST_DS_M:g} m, not {self.ds_m:g} m."
            )

        for name in ("start", "goal"):
            self._check_place(name, getattr(self, name))
        if len(self.way) == 2 and self.start == self.goal:
            raise InputError("Start and goal are the same point; move one of them.")
        way_m = sum(itertools.starmap(math.dist, itertools.pairwise(self.way)))
        if self.ds_m > max(way_m, half_a_cell_m):
            raise InputError(
                f"The sampling step of {self.ds_m:g} m is longer than the way from "
                f"start to goal, {way_m:g} m; reduce it."
            )
        if way_m > _MOST_SAMPLES * self.ds_m:
            raise InputError(
                f"A sampling step of {self.ds_m:g} m makes more than {_MOST_SAMPLES:,} samples of "
                f"the way from start to goal; increase it to {1.1 * way_m / _MOST_SAMPLES:.2g} m."
            )
        self._check_wind()

    def _check_wind(self) -> None:
        if not math.hypot(*self.wind) < self.aircraft.cruise_speed_m_s:
            raise InputError(
                f"A wind of {math.hypot(*self.wind):g} m/s is not below the airspeed of "
                f"{self.aircraft.name}, {self.aircraft.cruise_speed_m_s:g} m/s; reduce it or "
                f"choose a faster UAV."
            )

    @property
    def way(self) -> tuple[Point, ...]:
        """Start and goal.

        The problem of a whole mission has its via points between them, and may end where it starts.
        """
        return self.start, self.goal

    def among(self, zones: tuple[Zone, ...]) -> Problem:
        """Return the problem with other zones.

        Raises
        ------
        InputError
            If an end lies in a zone.
        """
        return replace(self, zones=zones)

    @property
    def as_paper(self) -> bool:
        """True if the evaluation of the papers holds, without the rules of safe flight."""
        return self.rules is None

    @cached_property
    def limits(self) -> Limits:
        """Limits of the aircraft in this wind, under these rules."""
        return Limits.of(self.aircraft, self.wind, self.rules)

    def slope_limits(
        self, east: NDArray[np.float64], north: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the steepest climbs and descents along unit directions, (n,) each, as tangents.

        See :func:`pathgene.host.problem.limits.slope_limits`.
        """
        wind = (0.0, 0.0) if self.rules is None else self.frame_wind
        return slope_limits(self.limits, self.aircraft.cruise_speed_m_s, wind, east, north)

    @cached_property
    def north_deg(self) -> float:
        """Direction of the frame's north, degrees clockwise from true north; 0 with ``as_paper``.

        It is 0 if the frame's north is true north within a tenth of a degree.
        """
        return 0.0 if self.rules is None else self.terrain.north_deg

    @property
    def frame_wind(self) -> tuple[float, float]:
        """The wind along the axes of the frame, m/s."""
        return self.in_frame(self.wind)

    def in_frame(self, wind: tuple[float, float]) -> tuple[float, float]:
        """Return a wind, towards true east and north, along the axes of the frame."""
        if wind == (0.0, 0.0) or not self.north_deg:
            return wind
        turn = math.radians(self.north_deg)
        east, north = wind
        return (
            east * math.cos(turn) - north * math.sin(turn),
            east * math.sin(turn) + north * math.cos(turn),
        )

    def true_heading_deg(self, frame_deg: float) -> float:
        """Convert a heading from the frame's north to a heading from true north, degrees."""
        return frame_deg + self.north_deg

    @cached_property
    def cost_base_m(self) -> float:
        """Altitude that the cost of altitude counts from: 0 m, or the lowest ground where lower.

        It is 0 with ``as_paper``.
        """
        lowest = 0.0 if self.rules is None else self.terrain.lowest
        return float(min(math.floor(lowest), 0))

    @property
    def headings(self) -> tuple[tuple[float, float] | None, tuple[float, float] | None]:
        """Unit vectors of the headings at start and goal in the frame; None where free."""
        start, goal = (
            None if deg is None else _direction(deg - self.north_deg)
            for deg in (self.start_heading_deg, self.goal_heading_deg)
        )
        return start, goal

    @cached_property
    def surface(self) -> Terrain:
        """Terrain that planners search above; see ``SearchRasters``.

        With ``as_paper`` it is the terrain itself.
        """
        if self._rasters is None:
            return self.terrain
        return self.terrain.raised(self._rasters.floor)

    @property
    def roof(self) -> NDArray[np.float64] | None:
        """Maximum altitude of the search at each node, (ny, nx); None if there is no limit."""
        return None if self._rasters is None else self._rasters.roof

    @cached_property
    def nofly_raster(self) -> NDArray[np.bool_]:
        """Nodes that the search treats as no-fly, (ny, nx) bool, row 0 the southernmost.

        With ``as_paper``, these are the nodes in a zone. Under the rules, they are the nodes whose
        cell square meets a zone or its margin. Zones to be flown over or under are in
        :attr:`surface` and :attr:`roof`, and zones that are only active at times are in
        :attr:`blocked_raster`.
        """
        inside = raster(self.zones, self.terrain) if self._rasters is None else self._rasters.nofly
        inside.flags.writeable = False
        return inside

    @cached_property
    def blocked_raster(self) -> NDArray[np.bool_]:
        """Nodes where planners must not put a waypoint: no-fly, void, or without room, (ny, nx).

        Zones that are active at times count as always active.
        """
        blocked = self._blocked(self.surface.elevation, self.nofly_raster, self.roof)
        return blocked if self._rasters is None else blocked | self._rasters.at_times

    def _blocked(
        self,
        floor: NDArray[np.float64],
        nofly: NDArray[np.bool_],
        roof: NDArray[np.float64] | None,
    ) -> NDArray[np.bool_]:
        """Return the nodes that are no-fly or have no room below the roof and the ceiling."""
        ceiling_m = self.limits.ceiling_m
        top = ceiling_m if roof is None else np.minimum(roof, ceiling_m)
        blocked: NDArray[np.bool_] = nofly | ~(floor <= top)
        return blocked

    def search_part(
        self, rows: slice, columns: slice
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Return the heights of :attr:`surface` and :attr:`blocked_raster` in a part of the grid.

        Only this part is computed, unless the whole is known or wanted: a replan cannot wait for
        the rasters of a map.
        """
        is_whole = (rows.stop - rows.start, columns.stop - columns.start) == self.terrain.shape
        if is_whole or self.rules is None or "_rasters" in vars(self):
            return self.surface.elevation[rows, columns], self.blocked_raster[rows, columns]
        found = self._search_rasters(rows, columns)
        blocked = self._blocked(found.floor, found.nofly, found.roof)
        return found.floor, blocked | found.at_times

    @property
    def zones_at_times(self) -> tuple[Zone, ...]:
        """Zones of all heights that are active only at times, which the evaluation checks.

        Empty with ``as_paper``; zones that end before they can be reached are left out.
        """
        if all(zone.t0_s is None and zone.t1_s is None for zone in self.zones):
            # The rasters take milliseconds.
            return ()
        return () if self._rasters is None else self._rasters.at_times_zones

    @cached_property
    def demand(self) -> Demand:
        """Clearance required on the way from start to goal; only for a problem with rules."""
        from pathgene.host.problem.surface import Demand

        assert self.rules is not None
        return Demand.of(self.terrain, self.start, self.goal, self.aircraft, self.rules)

    @property
    def _fastest_m_s(self) -> float:
        return self.aircraft.cruise_speed_m_s + math.hypot(*self.wind)

    @cached_property
    def _rasters(self) -> SearchRasters | None:
        if self.rules is None:
            return None
        rows, columns = self.terrain.shape
        return self._search_rasters(slice(0, rows), slice(0, columns))

    def _search_rasters(self, rows: slice, columns: slice) -> SearchRasters:
        from pathgene.host.problem.surface import SearchRasters

        assert self.rules is not None
        return SearchRasters(
            self.terrain,
            self.demand,
            self.zones,
            self.rules,
            self._fastest_m_s,
            (rows, columns),
        )

    def zone_at(self, point: Point, *, at_start: bool = False) -> str:
        """Return the zone that holds a point, x, y and altitude, in words; empty for none.

        Margins are ignored.

        A zone with times counts only at the start of the path, where the time is known.
        """
        x, y, z = point
        if self.rules is None:
            row, column = self.terrain.nearest_node(x, y)
            x, y = column * self.terrain.dx_m, row * self.terrain.dy_m
        for zone in self.zones:
            west, south, east, north = zone.footprint.box
            if not (
                west - _NEAR_M <= x <= east + _NEAR_M and south - _NEAR_M <= y <= north + _NEAR_M
            ):
                continue
            if not bool(zone.covers(np.array([x]), np.array([y]))[0, 0]):
                continue
            if self.rules is None or (
                (zone.lower_m is None or zone.lower_m <= z)
                and (zone.upper_m is None or z <= zone.upper_m)
                and (zone.t0_s is None or (at_start and zone.t0_s == 0))
                and (zone.t1_s is None or at_start)
            ):
                return f"the no-fly zone {zone.name}" if zone.name else "a no-fly zone"
        return ""

    def _check_place(self, name: str, point: Point) -> None:
        check_above_ground(name, self.terrain, point)
        x, y, _ = point
        if zone := self.zone_at(point, at_start=name == "start"):
            raise InputError(f"The {name} at ({x:g}, {y:g}) is inside {zone}; move it or the zone.")


def _rules(rules: Rules | None, as_paper: bool) -> Rules | None:
    """The rules of a problem; None with ``as_paper``."""
    if not isinstance(rules, Rules | None):
        raise InputError(f"The rules must be Rules, not {rules!r}.")
    if as_paper and rules not in (None, _SAFE):
        raise InputError("The evaluation of the papers has no rules; leave them out.")
    return None if as_paper else rules


def _direction(heading_deg: float) -> tuple[float, float]:
    """Return the unit vector east and north of a heading."""
    return math.sin(math.radians(heading_deg)), math.cos(math.radians(heading_deg))


def _heading(end: str, heading_deg: float | None) -> float | None:
    """A heading in degrees, from 0 to below 360."""
    if heading_deg is None:
        return None
    number = real(f"{end} heading", heading_deg)
    if not abs(number) <= 360:
        raise InputError(
            f"The {end} heading must be from -360 to 360 degrees from north, not {number:g}."
        )
    return number % 360
