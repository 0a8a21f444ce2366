"""The track that the guidance follows: straight lines and arcs, with a straight line at either end.

Distances along a route are horizontal and count from the start of the track, so they are negative
on the lead-in.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from pathgene.host.evaluation.geometry import Arc, Piece


__all__ = ["Place", "Route"]

# Length in metres of the straight beyond the goal, which the lookahead needs.
_BEYOND_M = 5000.0


class _Leg(NamedTuple):
    """A straight or an arc of ``run`` metres from ``s0``; ``curvature`` is in 1/m, to the left."""

    s0: float
    run: float
    x: float
    y: float
    east: float
    north: float
    curvature: float
    z: float
    slope: float


@dataclass(frozen=True)
class Place:
    """Place of a point relative to the route.

    Parameters
    ----------
    leg : int
        Number of the leg, a hint for the next search.
    along_m : float
        Distance along the route to the nearest point.
    cross_m : float
        Distance from the route to the point, positive to the left.
    """

    leg: int
    along_m: float
    cross_m: float


class Route:
    """Legs of a smoothed track between a lead-in and a run-out, both straight.

    Parameters
    ----------
    pieces : sequence of Straight or Arc
        Pieces in flying order; pieces without horizontal length are left out.
    lead_m : float
        Length of the lead-in, 0 or more. The lead-in has the direction and slope of the first
        piece.

    Attributes
    ----------
    length_m : float
        Horizontal length of the track, without lead-in and run-out.

    Raises
    ------
    ValueError
        If no piece has a horizontal length, or ``lead_m`` is negative.
    """

    def __init__(self, pieces: Sequence[Piece], lead_m: float = 0.0) -> None:
        if not lead_m >= 0:
            raise ValueError(f"Lead-in must be 0 m or more, not {lead_m!r}")
        flown = [piece for piece in pieces if piece.run_m > 0]
        if not flown:
            raise ValueError("Route must have a piece with a horizontal length")
        legs, along = [], 0.0
        for piece in flown:
            curvature = (
                math.copysign(1 / piece.radius_m, piece.turn_rad) if isinstance(piece, Arc) else 0.0
            )
            x, y, z = piece.start
            slope = piece.rise_m / piece.run_m
            legs.append(_Leg(along, piece.run_m, x, y, *piece.heading, curvature, z, slope))
            along += piece.run_m
        self.length_m = along
        first = legs[0]
        if lead_m > 0:
            legs.insert(
                0,
                first._replace(
                    s0=-lead_m,
                    run=lead_m,
                    x=first.x - lead_m * first.east,
                    y=first.y - lead_m * first.north,
                    z=first.z - lead_m * first.slope,
                    curvature=0.0,
                ),
            )
        last = legs[-1]
        (x, y), (east, north) = _point(last, last.run), _direction(last, last.run)
        z = last.z + last.slope * last.run
        legs.append(_Leg(along, _BEYOND_M, x, y, east, north, 0.0, z, last.slope))
        self._legs = legs

    @property
    def start(self) -> tuple[float, float, float, float, float]:
        """x, y, z of the start of the lead-in, metres, and its direction, east and north."""
        first = self._legs[0]
        return first.x, first.y, first.z, first.east, first.north

    def locate(self, x: float, y: float, leg: int = 0) -> Place:
        """Return the place of a point.

        Parameters
        ----------
        x, y : float
            Metres in the terrain's frame.
        leg : int, optional
            Leg of the previous place: the search continues from there and never goes back. By
            default it begins with the first leg.
        """
        while True:
            place = self._place(x, y, leg)
            here = self._legs[leg]
            if place.along_m < here.s0 + here.run or leg + 1 == len(self._legs):
                return place
            leg += 1

    def point(self, along_m: float, leg: int = 0) -> tuple[float, float]:
        """Return x, y at a distance along the route; ``leg`` is one at or before it."""
        here = self._leg(along_m, leg)
        return _point(here, along_m - here.s0)

    def height(self, along_m: float, leg: int = 0) -> tuple[float, float]:
        """Return altitude and slope (rise over run) at a distance along the route."""
        here = self._leg(along_m, leg)
        return here.z + here.slope * (along_m - here.s0), here.slope

    def curvature(self, along_m: float, leg: int = 0) -> float:
        """Return the curvature at a distance along the route, 1/m, positive to the left."""
        return self._leg(along_m, leg).curvature

    def _leg(self, along_m: float, leg: int) -> _Leg:
        legs = self._legs
        while leg + 1 < len(legs) and along_m >= legs[leg + 1].s0:
            leg += 1
        return legs[leg]

    def _place(self, x: float, y: float, leg: int) -> Place:
        here = self._legs[leg]
        dx, dy = x - here.x, y - here.y
        ahead = dx * here.east + dy * here.north
        aside = dy * here.east - dx * here.north
        if here.curvature == 0.0:
            return Place(leg, here.s0 + ahead, aside)
        # In the frame of the entry, the centre lies at (0, 1 / curvature).
        radius = abs(1 / here.curvature)
        inward = math.copysign(aside, aside * here.curvature)
        angle = math.atan2(ahead, radius - inward)
        if angle < -0.5 * math.pi and here.run > 0.5 * math.pi * radius:
            angle += 2 * math.pi
        off = radius - math.hypot(ahead, radius - inward)
        return Place(leg, here.s0 + angle * radius, math.copysign(1.0, here.curvature) * off)


def _point(leg: _Leg, along: float) -> tuple[float, float]:
    if leg.curvature == 0.0:
        return leg.x + along * leg.east, leg.y + along * leg.north
    angle = along * leg.curvature
    ahead = math.sin(angle) / leg.curvature
    aside = 2 * math.sin(0.5 * angle) ** 2 / leg.curvature
    return (
        leg.x + ahead * leg.east - aside * leg.north,
        leg.y + ahead * leg.north + aside * leg.east,
    )


def _direction(leg: _Leg, along: float) -> tuple[float, float]:
    angle = along * leg.curvature
    cos, sin = math.cos(angle), math.sin(angle)
    return leg.east * cos - leg.north * sin, leg.east * sin + leg.north * cos
