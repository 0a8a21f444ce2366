"""Faults of a flight: a limit that a leg, a turn or a circle breaks, and where."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation import laying as fields
from pathgene.host.mission.foreign.course import Point
from pathgene.host.mission.foreign.track import Track
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


__all__ = ["NO_END", "Fault", "Leg", "at_point", "disc", "place_on"]

Floats = NDArray[np.float64]

#: An end without effect on a required height.
NO_END = (0.0, 0.0, math.inf, 0.0)
# Directions of the rim of a disc.
_RIM = 1440


@dataclass(frozen=True)
class Fault:
    """A limit that a leg, a turn or a circle breaks.

    Parameters
    ----------
    limit : str
        ``clearance``, ``void``, ``map``, ``ceiling-agl``, ``ceiling``, ``service-ceiling``,
        ``climb``, ``descent``, ``turn`` or ``zone NAME``.
    chain, leg : int
        Number of the chain, and of the leg in it; of a turn or circle, the number of its point.
    is_leg : bool
        False for a turn or circle at a point.
    metres : float
        Metres by which the limit is broken; 0 over a void.
    place : tuple of float
        x, y and altitude of the worst place.
    allowed, value : float
        The limit and the value at the worst place, metres.
    span_m : tuple of float
        Horizontal metres along the leg at which the fault begins and ends.
    share : float
        Share of the leg at the worst place.
    zone : Zone, optional
        The zone that is entered.
    """

    limit: str
    chain: int
    leg: int
    is_leg: bool
    metres: float
    place: tuple[float, float, float]
    allowed: float
    value: float
    span_m: tuple[float, float] = (0.0, 0.0)
    share: float = 0.0
    zone: Zone | None = None

    @property
    def key(self) -> tuple[str, int, int, bool]:
        """Limit and leg, which have one fault."""
        return self.limit, self.chain, self.leg, self.is_leg


@dataclass(frozen=True, eq=False)
class Leg:
    """A row of a track, which is a part of a leg.

    Parameters
    ----------
    chain : int
        Number of the chain.
    track : Track
        Its track.
    row : int
        The row.
    """

    chain: int
    track: Track
    row: int

    @property
    def piece(self) -> Floats:
        """The row as an array of one row."""
        return self.track.rows[self.row : self.row + 1]

    @property
    def run_m(self) -> float:
        """Its horizontal length."""
        return float(self.track.rows[self.row, fields.RUN])

    def fault(
        self,
        limit: str,
        metres: float,
        along_m: float,
        allowed: float,
        value: float,
        span_m: tuple[float, float] | None = None,
        zone: Zone | None = None,
    ) -> Fault:
        """Return a fault at a distance along the row; the span is in metres along the row."""
        track, leg, run = self.track, int(self.track.legs[self.row]), self.run_m
        begin = float(track.begins_m[self.row])
        own = track.legs == leg
        end = float((track.begins_m[own] + track.rows[own, fields.RUN]).max())
        first, last = (0.0, run) if span_m is None else span_m
        return Fault(
            limit,
            self.chain,
            leg,
            True,
            metres,
            place_on(track.rows[self.row], along_m / run if run > 0 else 1.0),
            allowed,
            value,
            (begin + first, begin + last),
            min((begin + along_m) / end, 1.0) if end > 0 else 0.0,
            zone,
        )


def at_point(
    limit: str,
    chain: int,
    number: int,
    metres: float,
    place: tuple[float, float, float],
    allowed: float,
    value: float,
    zone: Zone | None = None,
) -> Fault:
    """Return a fault of a turn or circle at a point of a chain."""
    return Fault(limit, chain, number, False, metres, place, allowed, value, zone=zone)


def place_on(piece: Floats, share: float) -> tuple[float, float, float]:
    """Return the position at a share of a piece."""
    ux, uy = piece[fields.UX], piece[fields.UY]
    ahead, left = share * piece[fields.RUN], 0.0
    if piece[fields.ANGLE] > 0:
        radius = piece[fields.RUN] / piece[fields.ANGLE]
        turned = piece[fields.ANGLE] * share
        ahead = radius * math.sin(turned)
        left = piece[fields.SIDE] * radius * (1 - math.cos(turned))
    return (
        float(piece[fields.X] + ahead * ux - left * uy),
        float(piece[fields.Y] + ahead * uy + left * ux),
        float(piece[fields.Z] + share * piece[fields.RISE]),
    )


def disc(terrain: Terrain, point: Point, radius_m: float) -> tuple[Floats, Floats]:
    """Return the nodes in a disc around a point, places on its rim, and its middle."""
    rows, columns = terrain.shape
    axes = []
    for at, side, nodes in ((point.x_m, terrain.dx_m, columns), (point.y_m, terrain.dy_m, rows)):
        first = min(max(math.ceil((at - radius_m) / side), 0), nodes)
        last = min(max(math.floor((at + radius_m) / side) + 1, first), nodes)
        axes.append(np.arange(first, last) * side)
    x, y = (grid.ravel() for grid in np.meshgrid(*axes))
    inside = np.hypot(x - point.x_m, y - point.y_m) <= radius_m
    angles = np.linspace(0, 2 * np.pi, _RIM, endpoint=False)
    return (
        np.concatenate((x[inside], point.x_m + radius_m * np.cos(angles), [point.x_m])),
        np.concatenate((y[inside], point.y_m + radius_m * np.sin(angles), [point.y_m])),
    )
