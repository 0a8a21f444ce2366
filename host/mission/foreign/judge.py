"""Judge of a flight: every leg, turn and circle by the strict rule, with the places of faults."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import laying as fields
from pathgene.host.evaluation.problem_constants import constants_of
from pathgene.host.evaluation.reference import Utopia
from pathgene.host.mission.foreign.areas import Areas
from pathgene.host.mission.foreign.course import Chain, Point
from pathgene.host.mission.foreign.faults import Fault, Leg, at_point
from pathgene.host.mission.foreign.heights import Heights
from pathgene.host.mission.foreign.track import TOLERANCE_M, Late, Slopes, Track, lay
from pathgene.host.problem.limits import slope_limits
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.surface import Demand


__all__ = ["FlightProblem", "Judge"]

Floats = NDArray[np.float64]

# Directions of an arc in wind.
_ON_ARC = (np.arange(8) + 0.5) / 8
# Time by which a waypoint may ask for a climb early, as missions for late autopilots do.
_AHEAD_S = 1.1
# Tolerance of changes, which keep the limits themselves: places in files are rounded to this.
_EXACT_M = 0.01
# Legs before and after the judged ones that their turns depend on.
_AROUND = 3
_NO_UTOPIA = Utopia(1.0, 1.0, 1.0)


class FlightProblem(Problem):
    """The terrain, zones, aircraft, wind and rules of a flight, whose ends may lie anywhere."""

    def _check(self, half_a_cell_m: float) -> None:
        self._check_wind()


class Judge:
    """Judges flights over a terrain, among zones, by the rules and an aircraft.

    Parameters
    ----------
    problem : FlightProblem
        The terrain, zones, aircraft, wind and rules.

    Attributes
    ----------
    radius_m : float
        Radius of turns over the ground at cruise speed; infinite if the aircraft stalls in them.
    """

    def __init__(self, problem: FlightProblem) -> None:
        self.problem = problem
        constants = constants_of(problem, problem.ds_m, best=_NO_UTOPIA)
        self._heights, self._areas = Heights(problem, constants), Areas(problem)
        self.radius_m = problem.limits.turn_radius_m
        aircraft = problem.aircraft
        climb_m_s = aircraft.cruise_speed_m_s * math.sin(max(problem.limits.climb_rad, 0.0))
        late_s = aircraft.height_lag_s + _AHEAD_S
        self._late = Late(
            _AHEAD_S * climb_m_s, late_s * climb_m_s, late_s * aircraft.cruise_speed_m_s
        )

    @cached_property
    def exact(self) -> Judge:
        """The judge that reports faults of a centimetre, by which changes are measured."""
        other = copy(self)
        other._heights = self._heights.within(_EXACT_M)
        other._areas = self._areas.within(_EXACT_M)
        return other

    def faults(
        self, chains: Sequence[Chain], near: frozenset[tuple[int, int]] | None = None
    ) -> list[Fault]:
        """Return the faults in flying order, one for each leg or point and limit.

        Parameters
        ----------
        near : set of (int, int), optional
            Chains and legs that are judged, with the points at their ends; by default all.
        """
        found: dict[tuple[str, int, int, bool], Fault] = {}
        for fault in self._all(chains, near):
            known = found.get(fault.key, fault)
            worst = max(known, fault, key=lambda each: each.metres)
            (first, last), (other, beyond) = known.span_m, fault.span_m
            found[fault.key] = replace(worst, span_m=(min(first, other), max(last, beyond)))
        return sorted(found.values(), key=lambda each: (each.chain, each.leg, each.is_leg))

    def slopes(self, points: Sequence[Point]) -> list[Slopes]:
        """Return the steepest climb and descent along each leg."""
        steps = np.diff([(point.x_m, point.y_m) for point in points], axis=0)
        directions = steps / np.maximum(np.hypot(*steps.T), 1e-9)[:, None]
        climbs, descents = self._steepest(*directions.T)
        return [Slopes(*each) for each in zip(climbs.tolist(), descents.tolist(), strict=True)]

    def demand(self, chain: Chain) -> Demand:
        """Return the clearance that is required along a chain."""
        return self._heights.demand(chain)

    def track(self, points: Sequence[Point]) -> Track:
        """Return the track of two points or more."""
        return lay(points, self.radius_m, self.slopes(points), self._late)

    def lowest(self, chains: Sequence[Chain]) -> tuple[float, int, int] | None:
        """Return the least clearance with its chain and leg; None if no leg is in the air.

        Legs that begin or end on the ground do not count. The clearance is NaN over a void.
        """
        best: tuple[float, int, int] | None = None
        for number, chain in enumerate(chains):
            if len(chain.points) < 2:
                continue
            track = self.track(chain.points)
            flies = [not (a.is_ground or b.is_ground) for a, b in pairwise(chain.points)]
            rows = np.array([flies[leg] for leg in track.legs])
            found = self._heights.lowest(track.rows[rows], None if best is None else best[0])
            if found is not None:
                best = found[0], number, int(track.legs[rows][found[1]])
        return best

    def _all(
        self, chains: Sequence[Chain], near: frozenset[tuple[int, int]] | None
    ) -> Iterator[Fault]:
        for number, chain in enumerate(chains):
            demand = self._heights.demand(chain)
            if near is None:
                yield from self._of_points(number, chain.points, demand, None)
                continue
            legs = {leg for each, leg in near if each == number}
            if not legs:
                continue
            # A turn depends on the two points before and after it.
            first = max(min(legs) - _AROUND, 0)
            points = chain.points[first : max(legs) + _AROUND + 2]
            own = {leg - first for leg in legs}
            for fault in self._of_points(number, points, demand, own):
                yield replace(fault, leg=fault.leg + first)

    def _steepest(self, east: Floats, north: Floats) -> tuple[Floats, Floats]:
        problem = self.problem
        speed = problem.aircraft.cruise_speed_m_s
        return slope_limits(problem.limits, speed, problem.frame_wind, east, north)

    def _of_points(
        self, number: int, points: Sequence[Point], demand: Demand, legs: set[int] | None
    ) -> Iterator[Fault]:
        near = None if legs is None else {*legs, *(leg + 1 for leg in legs)}
        arrived = [points[0].z_m]
        if len(points) > 1:
            track = self.track(points)
            arrived = track.arrived_m
            rows = [
                Leg(number, track, row)
                for row in np.flatnonzero(track.rows[:, fields.LENGTH] > 0).tolist()
                if legs is None or int(track.legs[row]) in legs
            ]
            yield from self._turns(number, points, track, near)
            yield from self._slopes(track, rows)
            for row in rows:
                yield from self._heights.along(row, demand, with_span=legs is None)
                yield from self._heights.below_ceilings(row)
                yield from self._areas.along(row)
        for i, point in enumerate(points):
            if len(points) == 1 and point.circle_m is None and not point.is_ground:
                # No leg leads to it, so its place is judged.
                point = replace(point, circle_m=0.0)
            if point.circle_m is None or not (near is None or i in near):
                continue
            if point.asked_m is not None:
                tighter = point.circle_m - point.asked_m
                yield at_point(
                    "turn", number, i, tighter, point.place, point.circle_m, point.asked_m
                )
            # A return climbs to the height of its circle before it circles.
            begin_m = point.z_m if point.arrival == "return" else arrived[i]
            yield from self._heights.around(number, i, point, begin_m, demand)
            yield from self._areas.around(number, i, point, begin_m)

    def _slopes(self, track: Track, legs: Sequence[Leg]) -> Iterator[Fault]:
        """Yield climbs and descents that are too steep."""
        if not legs:
            return
        pieces = track.rows[[leg.row for leg in legs]]
        turned = pieces[:, fields.SIDE] * pieces[:, fields.ANGLE]
        ux, uy = pieces[:, fields.UX], pieces[:, fields.UY]
        found = []
        for share in _ON_ARC.tolist() if any(self.problem.wind) else [0.0]:
            cos, sin = np.cos(turned * share), np.sin(turned * share)
            found.append(self._steepest(ux * cos - uy * sin, uy * cos + ux * sin))
        climbs, descents = np.min(found, axis=0)
        for leg, piece, climb, descent in zip(legs, pieces, climbs, descents, strict=True):
            rise, run = float(piece[fields.RISE]), leg.run_m
            limit, tangent = ("climb", climb) if rise > 0 else ("descent", descent)
            allowed = float(tangent) * run / float(track.speeds[leg.row])
            # A turn is shorter than its legs, so its climb is steeper than theirs.
            free = self._late.leg_m if piece[fields.ANGLE] > 0 and rise > 0 else TOLERANCE_M
            if abs(rise) > allowed + free:
                yield leg.fault(limit, abs(rise) - allowed, run, allowed, abs(rise))

    def _turns(
        self, number: int, points: Sequence[Point], track: Track, near: set[int] | None
    ) -> Iterator[Fault]:
        """Yield the turns that do not fit."""
        for tight in track.tight:
            if near is not None and tight.point not in near:
                continue
            point = points[tight.point]
            radius = self.radius_m * point.speed**2
            missing = tight.missing_m if math.isfinite(tight.missing_m) else 2 * radius
            yield at_point(
                "turn", number, tight.point, missing, point.place, radius, tight.fitting_m
            )
