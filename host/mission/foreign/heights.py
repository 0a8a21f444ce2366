"""Heights of a flight over the ground of a map, and below ceilings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from copy import copy
from typing import Self

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import laying as fields
from pathgene.host.evaluation.constants import VOID_HEIGHT_M, Constants
from pathgene.host.evaluation.rule_kernels import (
    STACK_SHAPE,
    extreme_of_track,
    least_room_on_map,
)
from pathgene.host.evaluation.terrain_rule import (
    Part,
    Required,
    Surface,
    excess_m,
    extreme,
    room_on_map_m,
)
from pathgene.host.mission.foreign.course import Chain, Point
from pathgene.host.mission.foreign.faults import NO_END, Fault, Leg, at_point, disc
from pathgene.host.mission.foreign.track import TOLERANCE_M
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.surface import Demand
from pathgene.host.terrain.surface import ANY_VOID_M, is_beyond, surface_below


__all__ = ["Heights"]

Place = tuple[float, float, float]

# Too low by less than this is not reported: exports leave out waypoints that change little.
_LOW_M = 0.25
# The worst place of a leg is found to this, metres.
_STEP_M = 0.01
# A place on the ground may lie this far below the surface of the map, which is not exact.
_GROUND_M = 10.0
# Slope of a shallow approach, a tangent.
_SHALLOW = math.tan(math.radians(3.0))


class Heights:
    """Judges heights by the rules of a problem.

    Parameters
    ----------
    constants : Constants
        Constants of the kernels for the problem.
    """

    def __init__(self, problem: Problem, constants: Constants) -> None:
        assert problem.rules is not None
        self._problem, self._rules = problem, problem.rules
        heights = problem.terrain.elevation
        ground = np.where(np.isnan(heights), VOID_HEIGHT_M, heights).ravel()
        self._surface = Surface(ground, constants._replace(sampled=0, roofed=0))
        self._stack = np.empty(STACK_SHAPE)
        self._demands: dict[tuple[Place, Place], Demand] = {}
        self._low_m, self._tolerance_m = _LOW_M, TOLERANCE_M

    def within(self, tolerance_m: float) -> Self:
        """Return the same judge with another tolerance of clearances and ceilings, metres."""
        other = copy(self)
        other._low_m = other._tolerance_m = tolerance_m
        return other

    def demand(self, chain: Chain) -> Demand:
        """Return the clearance that is required, less near the ends of a chain.

        At a take-off or landing it grows by at most half of the slope of the leg.
        """
        first, last = chain.points[0], chain.end
        ends = first.place, last.place
        # It takes milliseconds, and remedies ask again.
        if ends not in self._demands:
            self._demands[ends] = Demand.of(
                self._problem.terrain, *ends, self._problem.aircraft, self._rules
            )
        demand = self._demands[ends]
        heights, beside = list(demand.heights_m), list(demand.heights_beside_m)
        start, goal = demand.slopes
        if first.is_ground:
            start = min(start, _half_slope(chain.points[:2]))
        if last.is_ground:
            goal = min(goal, _half_slope(chain.points[-2:]))
        for i, (point, is_low) in enumerate(((first, chain.starts_low), (last, True))):
            # The ground excuses no point in it, except a runway up to the error of the map.
            if not is_low or heights[i] < (-_GROUND_M if point.is_ground else 0.0):
                heights[i] = beside[i] = math.inf
        return Demand(
            demand.clearance_m,
            (heights[0], heights[1]),
            (beside[0], beside[1]),
            (start, goal),
            demand.ends,
        )

    def along(self, leg: Leg, demand: Demand, *, with_span: bool) -> Iterator[Fault]:
        """Yield the faults of a row that leaves the map, crosses a void or is too low.

        Without its span, a fault takes a tenth of the time.
        """
        low, below = self._required(demand)
        surface, piece = self._surface, leg.piece
        if excess_m(surface, low, below, piece, 1, self._stack) <= 0:
            return
        room, _, share = least_room_on_map(surface.c, piece, 1, self._rules.corridor_m)
        if room < -self._tolerance_m:
            yield leg.fault("map", -room, share * leg.run_m, 0.0, room)
        for required, is_beside in ((low, True), (below, False)):
            if with_span or room < 0:
                found = self._lowest_part(leg, required)
            else:
                worst, _, share = extreme_of_track(
                    surface, required, piece, 1, self._low_m, _STEP_M, self._stack
                )
                found = (
                    (worst, share * leg.run_m, (0.0, leg.run_m)) if worst > self._low_m else None
                )
            if found is not None:
                yield self._too_low(leg, demand, found, is_beside)

    def below_ceilings(self, leg: Leg) -> Iterator[Fault]:
        """Yield the ceilings that a row breaks."""
        z, rise = float(leg.piece[0, fields.Z]), float(leg.piece[0, fields.RISE])
        at_m = leg.run_m if rise > 0 else 0.0
        for limit, line in self._ceilings():
            top = max(z, z + rise)
            if top > line + self._tolerance_m:
                yield leg.fault(limit, top - line, at_m, line, top)
        most = self._rules.ceiling_agl_m
        if most is None:
            return
        required, part = Required(-1.0, most, 0.0, *NO_END, *NO_END), Part(0, 0.0, leg.run_m)
        found, along_m = extreme(
            self._surface, required, leg.piece, part, self._tolerance_m, _STEP_M, False, self._stack
        )
        if found > self._tolerance_m:
            yield leg.fault("ceiling-agl", found, along_m, most, most + found)

    def around(
        self, chain: int, number: int, point: Point, arrived_m: float, demand: Demand
    ) -> Iterator[Fault]:
        """Yield the faults of the disc around a point, between its altitude and the arrival's."""
        assert point.circle_m is not None
        terrain = self._problem.terrain
        low_m, high_m = min(arrived_m, point.z_m), max(arrived_m, point.z_m)
        x, y = disc(terrain, point, point.circle_m + self._rules.corridor_m)
        off = is_beyond(terrain, x, y)
        if off.any():
            beyond = (-x, -y, x - terrain.width_m, y - terrain.height_m)
            metres = max(float(each.max()) for each in beyond)
            if metres > self._tolerance_m:
                yield at_point("map", chain, number, metres, point.place, 0.0, -metres)
        x, y = x[~off], y[~off]
        if len(x):
            yield from self._low_disc(chain, number, (x, y, low_m), demand)
        for limit, line in self._ceilings():
            if high_m > line + self._tolerance_m:
                yield at_point(limit, chain, number, high_m - line, point.place, line, high_m)

    def lowest(self, rows: NDArray[np.float64], known_m: float | None) -> tuple[float, int] | None:
        """Return the least clearance of rows that is below a known one, and its row.

        The clearance is NaN over a void; None if no clearance is below the known one.
        """
        required = Required(1.0, 0.0, self._rules.corridor_m, *NO_END, *NO_END)
        known = -1e301 if known_m is None else -known_m
        excess, row, _ = extreme_of_track(
            self._surface, required, rows, len(rows), known, _STEP_M, self._stack
        )
        if not excess > known:
            return None
        return (-excess if excess < ANY_VOID_M else math.nan), int(row)

    def _ceilings(self) -> Iterator[tuple[str, float]]:
        """Yield the ceilings that there are."""
        ceilings = (
            ("ceiling", self._rules.ceiling_m),
            ("service-ceiling", self._problem.aircraft.service_ceiling_m),
        )
        for limit, line in ceilings:
            if line is not None:
                yield limit, line

    def _required(self, demand: Demand) -> tuple[Required, Required]:
        """Return the requirements in the corridor, and right below the track."""
        beside: tuple[float, ...] = ()
        for (x, y, _), height, slope in zip(
            demand.ends, demand.heights_beside_m, demand.slopes, strict=True
        ):
            beside += (x, y, height, slope)
        low = Required(1.0, demand.clearance_m, self._rules.corridor_m, *beside)
        start_m, goal_m = demand.heights_m
        return low, low._replace(half_width_m=0.0, start_height_m=start_m, goal_height_m=goal_m)

    def _lowest_part(
        self, leg: Leg, required: Required
    ) -> tuple[float, float, tuple[float, float]] | None:
        """Return the greatest excess of a row, its place, and the span of all; None for none."""
        surface, piece, stack = self._surface, leg.piece, self._stack
        run = leg.run_m
        parts = max(math.ceil(run / surface.c.ds_m), 1)
        worst, at_m = self._low_m, 0.0
        broken: list[int] = []
        for each in range(parts):
            part = Part(0, run * each / parts, run * (each + 1) / parts)
            if room_on_map_m(surface.c, piece, part, self._rules.corridor_m) < 0:
                continue
            found, along_m = extreme(surface, required, piece, part, self._low_m, 0.0, True, stack)
            if found <= self._low_m:
                continue
            broken.append(each)
            found, along_m = extreme(surface, required, piece, part, worst, _STEP_M, False, stack)
            if found > worst:
                worst, at_m = found, along_m
        if not broken:
            return None
        return worst, at_m, (run * broken[0] / parts, run * (broken[-1] + 1) / parts)

    def _too_low(
        self,
        leg: Leg,
        demand: Demand,
        found: tuple[float, float, tuple[float, float]],
        is_beside: bool,
    ) -> Fault:
        """Return the fault of a row with an excess over a requirement."""
        worst, at_m, span = found
        if worst > ANY_VOID_M:
            return leg.fault("void", 0.0, at_m, 0.0, 0.0, span)
        x, y, _ = leg.fault("clearance", worst, at_m, 0.0, 0.0).place
        allowed = float(demand.required_m(np.array([x]), np.array([y]), beside=is_beside)[0])
        return leg.fault("clearance", worst, at_m, allowed, allowed - worst, span)

    def _low_disc(
        self,
        chain: int,
        number: int,
        places: tuple[NDArray[np.float64], NDArray[np.float64], float],
        demand: Demand,
    ) -> Iterator[Fault]:
        x, y, z = places
        required = demand.required_m(x, y, beside=True)
        excess = surface_below(self._problem.terrain, x, y) + required - z
        worst = int(np.argmax(excess))
        metres, place = float(excess[worst]), (float(x[worst]), float(y[worst]), z)
        if not math.isfinite(metres):
            yield at_point("void", chain, number, 0.0, place, 0.0, 0.0)
        elif metres > self._low_m:
            allowed = float(required[worst])
            yield at_point("clearance", chain, number, metres, place, allowed, allowed - metres)


def _half_slope(leg: Sequence[Point]) -> float:
    """Return half of the slope of a leg, but no less than half of a shallow approach's."""
    a, b = leg[0], leg[-1]
    run = math.hypot(b.x_m - a.x_m, b.y_m - a.y_m)
    slope = abs(b.z_m - a.z_m) / run if run > 0 else math.inf
    return 0.5 * max(slope, _SHALLOW)
