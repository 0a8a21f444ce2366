"""Zones that a flight enters, with their margin, at any time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from copy import copy
from typing import Self

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.packed_zones import pack_zones
from pathgene.host.evaluation.zones import zone_intrusions, zone_metres
from pathgene.host.mission.foreign.course import Point
from pathgene.host.mission.foreign.faults import Fault, Leg, at_point, place_on
from pathgene.host.mission.foreign.track import TOLERANCE_M
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import numbers_of, wholes
from pathgene.host.problem.zones import Zone


__all__ = ["Areas"]

Floats = NDArray[np.float64]

# Places along a leg whose depth in a zone is measured.
_PLACES = 201
# A piece whose times are unknown: zones with times count as active.
_NO_TIMES = np.full(2, math.nan)


class Areas:
    """Judges legs and circles by the zones of a problem."""

    def __init__(self, problem: Problem) -> None:
        assert problem.rules is not None
        self._zones, self._margin_m = problem.zones, problem.rules.zone_margin_m
        self._packed = pack_zones(problem.zones, self._margin_m)
        all_zones = wholes(problem.zones)
        # The tiles of a zone have one number.
        self._names = [
            f"zone {all_zones[number - 1].name or number}" for number in numbers_of(problem.zones)
        ]
        self._tolerance_m = TOLERANCE_M

    def within(self, tolerance_m: float) -> Self:
        """Return the same judge with another tolerance, metres."""
        other = copy(self)
        other._tolerance_m = tolerance_m
        return other

    def along(self, leg: Leg) -> Iterator[Fault]:
        """Yield the faults of a row, at the deepest place in each zone."""
        if not self._zones or zone_metres(leg.piece, 1, _NO_TIMES, self._packed) <= 0:
            return
        found = zone_intrusions(leg.piece, 1, _NO_TIMES, self._packed)
        shares = np.linspace(0.0, 1.0, _PLACES)
        places = np.array([place_on(leg.piece[0], share) for share in shares.tolist()])
        for zone, name, entered in zip(self._zones, self._names, found, strict=True):
            if entered.metres <= 0:
                continue
            depths = self._depths(zone, *places.T)
            deepest = int(np.argmax(depths))
            metres = float(depths[deepest])
            if metres > self._tolerance_m:
                inside = shares[np.flatnonzero(depths > 0)[[0, -1]]] * leg.run_m
                yield leg.fault(
                    name,
                    metres,
                    float(shares[deepest]) * leg.run_m,
                    self._margin_m,
                    self._margin_m - metres,
                    (float(inside[0]), float(inside[1])),
                    zone,
                )

    def around(self, chain: int, number: int, point: Point, arrived_m: float) -> Iterator[Fault]:
        """Yield the zones that the disc around a point enters."""
        assert point.circle_m is not None
        low_m, high_m = min(arrived_m, point.z_m), max(arrived_m, point.z_m)
        for zone, name in zip(self._zones, self._names, strict=True):
            if zone.lower_m is not None and high_m <= zone.lower_m - self._margin_m:
                continue
            if zone.upper_m is not None and low_m >= zone.upper_m + self._margin_m:
                continue
            away = zone.footprint.distance_m(np.array([point.x_m]), np.array([point.y_m]))
            metres = point.circle_m + self._margin_m - float(away[0])
            if metres > self._tolerance_m:
                value = self._margin_m - metres
                yield at_point(
                    name, chain, number, metres, point.place, self._margin_m, value, zone
                )

    def _depths(self, zone: Zone, x: Floats, y: Floats, z: Floats) -> Floats:
        """Return how far places are inside a zone with its margin; negative outside."""
        applies = np.ones(len(x), dtype=bool)
        if zone.lower_m is not None:
            applies &= z > zone.lower_m - self._margin_m
        if zone.upper_m is not None:
            applies &= z < zone.upper_m + self._margin_m
        return np.where(applies, self._margin_m - zone.footprint.distance_m(x, y), -math.inf)
