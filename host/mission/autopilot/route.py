"""The waypoints that an autopilot gets: a smoothed track as legs that touch it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from pathgene.host.evaluation.geometry import Arc
from pathgene.host.evaluation.track import SmoothedTrack


__all__ = ["MOST_ACCEPTANCE_M", "RoutePoint", "leg_tolerance_m", "route"]

#: Greatest acceptance radius in metres: ArduPilot keeps it in a byte.
MOST_ACCEPTANCE_M = 255

# Maximum distance of a leg from the track at a waypoint.
_LEG_TOLERANCE_M = 2.0
_LEAST_TOLERANCE_M = 0.25
# Share of the corridor that the legs may use; the rest is the autopilot's.
_SHARE_OF_CORRIDOR = 0.25
# Acceptance radius of a waypoint on the track itself, where the heading does not change.
_ON_TRACK_M = 10
# Points this close together are one point; an arc with tangents this short is a corner.
_SAME_M = 0.01
_SHORT_TANGENT_M = 1.5


@dataclass(frozen=True)
class RoutePoint:
    """A waypoint of an autopilot.

    Parameters
    ----------
    x_m, y_m, z_m : float
        Position in the terrain's local frame; ``z_m`` is an altitude.
    acceptance_m : int
        Distance at which the autopilot may turn to the next waypoint: whole metres, 1 to 255, less
        than the distance to either neighbour unless that is under 2 m.
    """

    x_m: float
    y_m: float
    z_m: float
    acceptance_m: int


def leg_tolerance_m(corridor_m: float | None) -> float:
    """Return the maximum distance of a waypoint from the track, metres.

    Parameters
    ----------
    corridor_m : float or None
        Half the width of the strip that keeps the clearance; None without such a rule.
    """
    if corridor_m is None:
        return _LEG_TOLERANCE_M
    return min(_LEG_TOLERANCE_M, max(_LEAST_TOLERANCE_M, _SHARE_OF_CORRIDOR * corridor_m))


def route(track: SmoothedTrack, tolerance_m: float) -> list[RoutePoint]:
    """Return the waypoints of a track, start first, goal last.

    The legs between the waypoints are the straight pieces of the track and tangents of its arcs: an
    arc becomes its two end points and, between them, the corners of a polygon around it. An
    autopilot that begins its turn at the acceptance radius of a corner begins where the leg touches
    the arc, and so flies the arc; an autopilot that overflies each corner leaves the track by at
    most ``tolerance_m``.

    Parameters
    ----------
    tolerance_m : float
        Maximum distance of a corner from its arc, above 0.
    """
    points: list[RoutePoint] = []
    for point in _points(track, tolerance_m):
        # The tangent point that ends one arc may begin the next.
        if not points or _apart_m(points[-1], point) >= _SAME_M:
            points.append(point)
    distances = [_across_m(*pair) for pair in pairwise(points)]
    nearest = [min(pair) for pair in pairwise([math.inf, *distances, math.inf])]
    return [
        replace(point, acceptance_m=_limited(point.acceptance_m, near))
        for point, near in zip(points, nearest, strict=True)
    ]


def _points(track: SmoothedTrack, tolerance_m: float) -> Iterator[RoutePoint]:
    """Yield the waypoints; two may be at one place, and acceptance radii may be too large."""
    pieces = track.pieces
    yield RoutePoint(*pieces[0].start, _ON_TRACK_M)
    for piece, following in zip(pieces, (*pieces[1:], None), strict=True):
        if isinstance(piece, Arc):
            yield from _around(piece, tolerance_m)
        elif not isinstance(following, Arc):
            yield RoutePoint(*piece.stop, _ON_TRACK_M)
    if isinstance(pieces[-1], Arc):
        yield _on_track(pieces[-1], 1.0)


def _around(arc: Arc, tolerance_m: float) -> Iterator[RoutePoint]:
    """Yield the tangent points of an arc and the corners between them."""
    turn_rad, radius_m = abs(arc.turn_rad), arc.radius_m
    widest_rad = 2 * math.acos(radius_m / (radius_m + tolerance_m))
    corners = max(1, math.ceil(turn_rad / widest_rad))
    half_rad = 0.5 * turn_rad / corners
    tangent_m = radius_m * math.tan(half_rad)
    is_short = corners == 1 and tangent_m < _SHORT_TANGENT_M
    if not is_short:
        yield _on_track(arc, 0.0)
    east, north = arc.heading
    side = math.copysign(radius_m, arc.turn_rad)
    centre_x, centre_y = arc.start[0] - side * north, arc.start[1] + side * east
    outwards = 1 / math.cos(half_rad)
    middles = (np.arange(corners) + 0.5) / corners
    for x, y, z in arc.points(middles).tolist():
        yield RoutePoint(
            centre_x + (x - centre_x) * outwards,
            centre_y + (y - centre_y) * outwards,
            z,
            math.floor(tangent_m),
        )
    if not is_short:
        yield _on_track(arc, 1.0)


def _on_track(arc: Arc, fraction: float) -> RoutePoint:
    ((x, y, z),) = arc.points(np.array([fraction])).tolist()
    return RoutePoint(x, y, z, _ON_TRACK_M)


def _limited(acceptance_m: int, near_m: float) -> int:
    """Return the acceptance radius of a waypoint whose nearest neighbour is ``near_m`` away."""
    below = MOST_ACCEPTANCE_M if near_m > MOST_ACCEPTANCE_M else math.ceil(near_m) - 1
    return max(1, min(acceptance_m, below))


def _apart_m(a: RoutePoint, b: RoutePoint) -> float:
    return math.dist((a.x_m, a.y_m, a.z_m), (b.x_m, b.y_m, b.z_m))


def _across_m(a: RoutePoint, b: RoutePoint) -> float:
    return math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)
