"""The current situation: ground, zones, wind and goal; it checks tracks by the strict rule."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Sequence

import numpy as np

from pathgene.host.evaluation.constants import COORDINATE_LIMIT_M, Floats
from pathgene.host.evaluation.geometry import Piece
from pathgene.host.evaluation.laid_track import lay_pieces
from pathgene.host.evaluation.problem_constants import constants_of
from pathgene.host.evaluation.reference import Utopia
from pathgene.host.evaluation.strict_rule import StrictRule
from pathgene.host.evaluation.zones import pack_zones, zone_metres
from pathgene.host.problem.ends import Point
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.replanning.tracks import Pose, Track, part, run_of


__all__ = ["Present"]

#: Length in metres of the parts of a track that are checked to find the first unsafe place.
_PART_M = 50.0
#: Length of the piece that stands for a point, metres.
_POINT_M = 0.01
#: Placeholder: costs are not evaluated here, and the line to a new goal may have no cost.
_NO_COSTS = Utopia(1.0, 1.0, 1.0)
#: Pieces as the kernels take them, and their times: see :func:`lay_pieces`.
_Laid = tuple[Floats, Floats]


class Present:
    """The zones, goal and wind that are known at a moment.

    Less clearance is required near the mission's start and goal, and nowhere else.

    Parameters
    ----------
    mission : Problem
        The problem of the whole mission, with rules; its zones, goal and wind are ignored.
    zones : sequence of Zone
        The current zones, with times counted from now.
    goal : (float, float, float)
        The current goal. It may lie in a zone.
    wind : (float, float)
        The current wind, m/s.
    """

    def __init__(
        self, mission: Problem, zones: Sequence[Zone], goal: Point, wind: tuple[float, float]
    ) -> None:
        bare = dataclasses.replace(
            mission, zones=(), goal=goal, wind=wind, start_heading_deg=None, goal_heading_deg=None
        )
        assert bare.rules is not None
        self.mission, self.zones, self.goal, self.wind = mission, tuple(zones), goal, wind
        self._bare = bare
        self._rules: dict[float, StrictRule] = {}
        margins = {True: bare.rules.zone_margin_m, False: 0.0}
        self._packed = {
            margin: [pack_zones([zone], metres) for zone in self.zones]
            for margin, metres in margins.items()
        }

    @property
    def turn_radius_m(self) -> float:
        """Radius of turns over ground."""
        return self._bare.limits.turn_radius_m

    @property
    def speeds_m_s(self) -> tuple[float, float]:
        """Minimum and maximum speed over ground."""
        airspeed, wind = self._bare.aircraft.cruise_speed_m_s, math.hypot(*self.wind)
        return airspeed - wind, airspeed + wind

    def climb(self, pose: Pose) -> float:
        """Return the steepest climb ahead, rise over run, of the aircraft in this wind."""
        climbs, _ = self._bare.slope_limits(np.array([pose.east]), np.array([pose.north]))
        return float(climbs[0])

    def is_safe(self, pieces: Sequence[Piece]) -> bool:
        """Return whether a track keeps clearance, ceilings and the margins of zones."""
        laid = self._laid(pieces)
        return self._off_limits_m(pieces, laid) == 0 and self._in_zones_m(laid) == 0

    def off_limits_m(self, pieces: Sequence[Piece], share: float = 1.0) -> float:
        """Return the metres of a track that are too low, too high or off the map.

        Too low means below a ``share`` of the clearance, over the surface on both sides of the
        track within that share of the corridor.
        """
        return self._off_limits_m(pieces, self._laid(pieces), share)

    def _off_limits_m(self, pieces: Sequence[Piece], laid: _Laid, share: float = 1.0) -> float:
        if not all(_is_near(piece.start) for piece in pieces):
            return math.inf
        ceiling = self._bare.limits.ceiling_m
        if any(max(piece.start[2], piece.start[2] + piece.rise_m) > ceiling for piece in pieces):
            return math.inf
        return self._rule(share).off_demand_m(laid[0])

    def in_zones_m(
        self, pieces: Sequence[Piece], *, margin: bool = True, among: Collection[int] | None = None
    ) -> float:
        """Return the metres of a track in zones, with or without their ``margin``.

        Only zones with numbers in ``among`` count; a place in two zones counts twice.
        """
        return self._in_zones_m(self._laid(pieces), margin=margin, among=among)

    def _in_zones_m(
        self, laid: _Laid, *, margin: bool = True, among: Collection[int] | None = None
    ) -> float:
        rows, times = laid
        return sum(
            zone_metres(rows, len(rows), times, packed)
            for number, packed in enumerate(self._packed[margin])
            if among is None or number in among
        )

    def zones_at(self, pose: Pose, *, margin: bool = True) -> set[int]:
        """Return the numbers of the zones that contain a place."""
        point = [pose.straight(_POINT_M)]
        return {
            number
            for number in range(len(self.zones))
            if self.in_zones_m(point, margin=margin, among=(number,)) > 0
        }

    @property
    def is_goal_in_zone(self) -> bool:
        """True if the goal is in a zone, ignoring margins."""
        return bool(self.zones_at(Pose(*self.goal, 1.0, 0.0, 0.0), margin=False))

    def safe_until_m(self, pieces: Track, first_m: float) -> float:
        """Return the distance along a track up to which it is safe from ``first_m`` on.

        It is infinite if the rest of the track is safe; otherwise it is the end of the last safe
        part, where the track is divided into equal parts of up to 50 m.
        """
        if self.is_safe(part(pieces, first_m)):
            return math.inf
        length = run_of(pieces)
        parts = max(math.ceil((length - first_m) / _PART_M), 1)
        ends = [first_m + (length - first_m) * number / parts for number in range(parts + 1)]
        # A track with an unsafe part is unsafe, so the parts are bisected.
        safe, unsafe = 0, parts
        while unsafe - safe > 1:
            middle = (safe + unsafe) // 2
            if self.is_safe(part(pieces, first_m, ends[middle])):
                safe = middle
            else:
                unsafe = middle
        return ends[safe]

    def _rule(self, share: float) -> StrictRule:
        if share not in self._rules:
            bare, rules = self._bare, self._bare.rules
            assert rules is not None
            if share < 1:
                clearance_m, corridor_m = share * rules.clearance_m, share * rules.corridor_m
                less = dataclasses.replace(rules, clearance_m=clearance_m, corridor_m=corridor_m)
                bare = dataclasses.replace(bare, rules=less)
            constants = constants_of(bare, bare.ds_m, best=_NO_COSTS)
            self._rules[share] = StrictRule(bare, constants)
        return self._rules[share]

    def _laid(self, pieces: Sequence[Piece]) -> _Laid:
        return lay_pieces(pieces, self._bare.aircraft.cruise_speed_m_s)


def _is_near(point: Point) -> bool:
    return all(abs(value) < COORDINATE_LIMIT_M for value in point)
