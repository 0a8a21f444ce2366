"""Tracks that need no planner: out of a zone, and onto a safe holding circle.

Both are searched among turns with the smallest radius, each followed by a straight line, and both
are checked by the strict rule in the current situation before they are flown.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from pathgene.host.evaluation.geometry import Piece
from pathgene.host.replanning.present import Present
from pathgene.host.replanning.tracks import Pose, Track, end_of, part, pose_at, run_of


__all__ = ["Holding", "holding_on", "shortest_way_out_m", "way_on", "way_out"]

# Step in degrees of the turns that are tried to both sides, up to half a circle.
_TURN_DEG = 15
_FINE_DEG = 3
# Maximum length of a straight line out of a zone, and accuracy of its end, metres.
_FARTHEST_M = 20_000.0
_BORDER_M = 0.5
# Shares of the steepest climb that are tried.
_CLIMBS = (0.0, 0.5, 0.9)
# Shares of the clearance that a route keeps, in this order: less clearance is better than a zone,
# and a zone is better than the ground.
_CLEARANCES = (1.0, 0.5, 0.1)
# Length in turn radii of the straight line beyond the margin on a route out: room to turn away.
_BEYOND_RADII = 0.5
# Circles: radii in turn radii, and number of pieces of each.
_CIRCLES = (1.1, 1.6, 2.5)
_QUARTERS = 4
# Routes onto a circle: turns, degrees, and straight lines after them, in turn radii.
_WAY_TURNS_DEG = (0, 30, -30, 60, -60, 90, -90, 135, -135, 180, -180)
_WAY_RUNS = (0.5, 2.0, 6.0)
# Number of places along a track from which routes are tried.
_ENTRIES = 12


@dataclass(frozen=True)
class Holding:
    """A holding circle, and the route to it.

    Parameters
    ----------
    along_m : float
        Distance along the track at which the route leaves it.
    way : tuple of Straight or Arc
        Route from there to the circle; empty if the track touches the circle.
    """

    along_m: float
    way: Track
    circle: Track

    def track(self, before: Track, rounds: int) -> Track:
        """Return the track onto the circle and ``rounds`` times around, after ``before``."""
        return (*before, *self.way, *(self.circle * rounds))

    def is_safe(self, present: Present) -> bool:
        """Return whether route and circle are safe in the current situation."""
        return present.is_safe((*self.way, *self.circle))


def holding_on(present: Present, track: Track, first_m: float, last_m: float) -> Holding | None:
    """Return a holding circle whose route leaves a track as late as possible, or None.

    Parameters
    ----------
    first_m, last_m : float
        Range of distances along the track where the route may leave it; the track is safe in this
        range.
    """
    last_m = min(last_m, run_of(track))
    if not first_m <= last_m:
        return None
    entries = [last_m - (last_m - first_m) * number / (_ENTRIES - 1) for number in range(_ENTRIES)]
    poses = [(along, pose_at(track, along)) for along in entries]
    for along, pose in poses:
        circle = _circle_at(present, pose)
        if circle is not None:
            return Holding(along, (), circle)
    for along, pose in poses:
        for way in _ways(present, pose, _WAY_RUNS):
            if present.is_safe(way):
                circle = _circle_at(present, end_of(way[-1]))
                if circle is not None:
                    return Holding(along, way, circle)
    return None


def _circle_at(present: Present, pose: Pose) -> Track | None:
    """Return a level circle that a pose is tangent to and that is safe."""
    for radii, side in itertools.product(_CIRCLES, (1, -1)):
        circle: list[Piece] = []
        at = pose
        for _ in range(_QUARTERS):
            circle.append(at.arc(radii * present.turn_radius_m, side * 2 * math.pi / _QUARTERS))
            at = end_of(circle[-1])
        if present.is_safe(circle):
            return tuple(circle)
    return None


def _ways(
    present: Present, pose: Pose, runs: Iterable[float], shares: Iterable[float] = _CLIMBS
) -> Iterator[Track]:
    """Yield routes from a pose: a turn and a line of some turn radii, level or climbing."""
    for run, share, turn_deg in itertools.product(runs, shares, _WAY_TURNS_DEG):
        yield _turn_and_straight(present, pose, turn_deg, share, run * present.turn_radius_m)


def _turn_and_straight(
    present: Present, pose: Pose, turn_deg: float, share: float, run_m: float
) -> Track:
    """Return a turn with the smallest radius and a line; arcs turn by less than half a circle."""
    pieces: list[Piece] = []
    slope = share * present.climb(pose) if share else 0.0
    at = pose
    for _ in range(2):
        if turn_deg:
            pieces.append(at.arc(present.turn_radius_m, math.radians(turn_deg) / 2, slope))
            at = end_of(pieces[-1])
    slope = share * present.climb(at) if share else 0.0
    pieces.append(at.straight(run_m, slope))
    return tuple(pieces)


def way_out(present: Present, pose: Pose) -> Track | None:
    """Return the shortest route out of all zones and their margins that keeps the clearance.

    If none keeps it, the shortest route that keeps half of it is taken, or a tenth; None if there
    is no route out above the ground. Among equally short routes, the steepest climb wins, because
    the ground beyond the route may rise more steeply than the aircraft climbs.
    """
    found = sorted(
        (
            (length, -share, way)
            for share in _CLIMBS
            for length, way in _fan(present, pose, share, _TURN_DEG, margin=True)
        ),
        key=lambda each: each[:2],
    )
    for clearance, (_, _, way) in itertools.product(_CLEARANCES, found):
        if present.off_limits_m(way, clearance) == 0:
            return way
    return None


def way_on(present: Present, pose: Pose) -> Track:
    """Return a track to continue on from a place that has neither a path nor a circle.

    It is the longest route that avoids zones or, if there is none, leads through them, with as much
    of the clearance as :func:`way_out` keeps, climbing if possible. If every route leads into the
    ground, it is the one with the fewest metres in the ground.
    """
    ways = list(_ways(present, pose, _WAY_RUNS[::-1], _CLIMBS[::-1]))
    for keeps_out, clearance, way in itertools.product((True, False), _CLEARANCES, ways):
        if present.off_limits_m(way, clearance) == 0 and not (
            keeps_out and present.in_zones_m(way) > 0
        ):
            return way
    climbing = (
        _turn_and_straight(present, pose, turn, _CLIMBS[-1], _WAY_RUNS[-1] * present.turn_radius_m)
        for turn in _WAY_TURNS_DEG
    )
    return min(climbing, key=lambda way: present.off_limits_m(way, 0.0))


def shortest_way_out_m(present: Present, pose: Pose) -> float:
    """Return the length of the shortest route out of all zones, ignoring margins and ground.

    It is the yardstick of an escape: a turn with the smallest radius and a straight line. It is
    infinite if there is no such route, and 0 outside the zones.
    """
    if not present.zones_at(pose, margin=False):
        return 0.0
    ways = _fan(present, pose, 0.0, _FINE_DEG, margin=False)
    return min((length for length, _ in ways), default=math.inf)


def _fan(
    present: Present, pose: Pose, share: float, every_deg: float, *, margin: bool
) -> Iterator[tuple[float, Track]]:
    """Yield the metres to the border, and a track that leads slightly beyond it."""
    beyond_m = _BEYOND_RADII * present.turn_radius_m if margin else 0.0
    best = math.inf
    steps = round(180 / every_deg)
    for number in sorted(range(-steps, steps + 1), key=abs):
        ray = _turn_and_straight(present, pose, number * every_deg, share, _FARTHEST_M)
        turn_m = run_of(ray[:-1])
        if turn_m > best:
            break
        length = _leaves_m(present, ray, turn_m, margin=margin)
        if math.isfinite(length):
            best = min(best, length)
            yield length, part(ray, 0.0, length + beyond_m)


def _leaves_m(present: Present, ray: Track, turn_m: float, *, margin: bool) -> float:
    """Return the distance along a ray at which it has left the zones that it begins in.

    Zones that the ray enters before it has left these count too. Infinite if the ray does not end
    outside.
    """
    among: set[int] = set()
    leaves = 0.0
    while inside := present.zones_at(pose_at(ray, leaves), margin=margin) - among:
        among |= inside
        low, high = leaves, turn_m + _FARTHEST_M
        if present.in_zones_m(part(ray, high - _BORDER_M), margin=margin, among=among) > 0:
            return math.inf
        while high - low > _BORDER_M:
            middle = 0.5 * (low + high)
            if present.in_zones_m(part(ray, middle), margin=margin, among=among) > 0:
                low = middle
            else:
                high = middle
        leaves = high
    return leaves
