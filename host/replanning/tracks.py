"""Tracks as sequences of pieces: places on them, and parts of them.

Distances along a track are horizontal and count from its beginning, as in
:class:`pathgene.host.flight.route.Route`. Pieces without horizontal length are skipped.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from pathgene.host.evaluation.geometry import Arc, Piece, Straight


__all__ = ["Pose", "Track", "end_of", "is_smooth", "part", "pose_at", "run_of"]

# See is_smooth.
_GAP_M, _LEAST_COSINE = 1.0, math.cos(math.radians(3.0))

#: Pieces in flying order.
Track = tuple[Piece, ...]


@dataclass(frozen=True)
class Pose:
    """A place in the air, and the direction of flight there.

    Parameters
    ----------
    x, y, z : float
        Metres.
    east, north : float
        Horizontal unit direction.
    """

    x: float
    y: float
    z: float
    east: float
    north: float
    slope: float

    @property
    def point(self) -> tuple[float, float, float]:
        """x, y and altitude."""
        return self.x, self.y, self.z

    @property
    def heading_deg(self) -> float:
        """Heading in degrees clockwise from the frame's north, 0 to below 360."""
        return math.degrees(math.atan2(self.east, self.north)) % 360

    def straight(self, run_m: float, slope: float = 0.0) -> Straight:
        """Return a straight piece that starts here."""
        stop = (
            self.x + run_m * self.east,
            self.y + run_m * self.north,
            self.z + run_m * slope,
        )
        return Straight(self.point, stop, (self.east, self.north), run_m, run_m * slope)

    def arc(self, radius_m: float, turn_rad: float, slope: float = 0.0) -> Arc:
        """Return a turn that starts here, to the left if ``turn_rad`` is positive."""
        rise_m = radius_m * abs(turn_rad) * slope
        return Arc(self.point, (self.east, self.north), radius_m, turn_rad, rise_m)


def is_smooth(pieces: Sequence[Piece]) -> bool:
    """Return whether each piece with a horizontal length begins where the previous one ends.

    Places count as equal within 1 m, and directions within 3 degrees.
    """
    flown = [piece for piece in pieces if piece.run_m > 0]
    return all(
        math.dist(end_of(before).point, after.start) <= _GAP_M
        and end_of(before).east * after.heading[0] + end_of(before).north * after.heading[1]
        >= _LEAST_COSINE
        for before, after in itertools.pairwise(flown)
    )


def run_of(pieces: Iterable[Piece]) -> float:
    """Return the horizontal length of a track, metres."""
    return sum(piece.run_m for piece in pieces)


def end_of(piece: Piece) -> Pose:
    """Return the pose at the end of a piece with a horizontal length."""
    return _pose(piece, piece.run_m)


def pose_at(pieces: Sequence[Piece], along_m: float) -> Pose:
    """Return the pose at a distance along a track, clamped to its ends.

    Raises
    ------
    ValueError
        If no piece has a horizontal length.
    """
    flown = [piece for piece in pieces if piece.run_m > 0]
    if not flown:
        raise ValueError("Track must have a piece with a horizontal length")
    left = max(along_m, 0.0)
    for piece in flown:
        if left < piece.run_m:
            return _pose(piece, left)
        left -= piece.run_m
    return end_of(flown[-1])


def part(pieces: Sequence[Piece], first_m: float, last_m: float = math.inf) -> Track:
    """Return the part of a track between two distances along it; empty if there is none."""
    found: list[Piece] = []
    passed = 0.0
    for piece in pieces:
        run = piece.run_m
        start, stop = max(first_m - passed, 0.0), min(last_m - passed, run)
        if run > 0 and start < stop:
            found.append(piece if (start, stop) == (0.0, run) else _cut(piece, start, stop))
        passed += run
    return tuple(found)


def _pose(piece: Piece, along_m: float) -> Pose:
    slope = piece.rise_m / piece.run_m
    x, y, z = piece.start
    east, north = piece.heading
    if isinstance(piece, Straight):
        return Pose(
            x + along_m * east, y + along_m * north, z + along_m * slope, east, north, slope
        )
    side = math.copysign(1.0, piece.turn_rad)
    angle = along_m / piece.radius_m
    ahead = piece.radius_m * math.sin(angle)
    aside = side * piece.radius_m * 2 * math.sin(0.5 * angle) ** 2
    cos, sin = math.cos(angle), side * math.sin(angle)
    return Pose(
        x + ahead * east - aside * north,
        y + ahead * north + aside * east,
        z + along_m * slope,
        cos * east - sin * north,
        cos * north + sin * east,
        slope,
    )


def _cut(piece: Piece, start: float, stop: float) -> Piece:
    """Return the part of a piece between two distances along it."""
    pose = _pose(piece, start)
    run = stop - start
    if isinstance(piece, Straight):
        return pose.straight(run, pose.slope)
    return pose.arc(piece.radius_m, math.copysign(run / piece.radius_m, piece.turn_rad), pose.slope)
