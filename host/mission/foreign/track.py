"""The track of a flight: straight legs, and turns that begin before their points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.constants import COLLINEAR_RAD
from pathgene.host.evaluation.geometry import Arc, Piece, Straight
from pathgene.host.evaluation.laid_track import lay_pieces
from pathgene.host.evaluation.laying import LENGTH
from pathgene.host.mission.foreign.course import Point


__all__ = ["TOLERANCE_M", "Late", "Slopes", "Tight", "Track", "lay"]

#: Faults of less than this are not reported: files round their places.
TOLERANCE_M = 0.1

# A turn fits with this share of the aircraft's radius: exports simplify their legs.
_FITS = 0.97
# A turn of points that lie on a circle which the aircraft can fly follows the circle; its legs are
# no farther from the circle than this.
_SAGITTA_M = 2.5
_ROUND = 0.99


@dataclass(frozen=True)
class Slopes:
    """Tangents of the steepest climb and descent at cruise speed along a leg."""

    climb: float
    descent: float


@dataclass(frozen=True)
class Late:
    """Heights that an aircraft may lack in a climb, as autopilots are late.

    Parameters
    ----------
    leg_m : float
        Maximum growth on a leg.
    most_m : float
        Maximum in all, and maximum growth on a short first leg.
    short_m : float
        Maximum length of a short leg.
    """

    leg_m: float
    most_m: float
    short_m: float

    def on(self, leg: int, run_m: float) -> Late:
        """Return the bounds for a leg."""
        is_short_first = leg == 0 and run_m <= self.short_m
        return replace(self, leg_m=self.most_m) if is_short_first else self


@dataclass(frozen=True)
class Tight:
    """A turn that does not fit.

    Parameters
    ----------
    point, leg : int
        Number of the point, and of the leg that is too short for the turns at its ends.
    missing_m : float
        Length that the leg lacks; infinite where the track turns back.
    fitting_m : float
        Radius with which the turns would fit.
    """

    point: int
    leg: int
    missing_m: float
    fitting_m: float


@dataclass(frozen=True, eq=False)
class Track:
    """The pieces of a track.

    Parameters
    ----------
    rows : ndarray
        The pieces as the kernels of the evaluation take them; a row may have no length.
    legs : ndarray
        Number of the leg of each row: leg 3 leads from point 3 to point 4. An arc belongs to the
        leg before it.
    begins_m : ndarray
        Horizontal metres along the leg to the beginning of each row.
    speeds : ndarray
        Airspeed of each row as a multiple of the cruise speed.
    arrived_m : list of float
        Altitude at which each point is reached.
    tight : list of Tight
        Turns that do not fit.
    pieces : tuple of Straight or Arc
        The piece of each row.
    """

    rows: NDArray[np.float64]
    legs: NDArray[np.int64]
    begins_m: NDArray[np.float64]
    speeds: NDArray[np.float64]
    arrived_m: list[float]
    tight: list[Tight]
    pieces: tuple[Piece, ...]

    @property
    def length_m(self) -> float:
        """Length in three dimensions."""
        return float(self.rows[:, LENGTH].sum())


def lay(points: Sequence[Point], radius_m: float, slopes: Sequence[Slopes], late: Late) -> Track:
    """Return the track of a chain of points.

    The height is linear along a leg. On a climb that is a little too steep, the aircraft climbs as
    it can, and arrives below the point.

    Parameters
    ----------
    radius_m : float
        Radius of the aircraft's turns over the ground, at its cruise speed.
    slopes : sequence of Slopes
        For each leg.
    late : Late
        Bounds of a climb that is a little too steep.
    """
    runs = [math.hypot(b.x_m - a.x_m, b.y_m - a.y_m) for a, b in pairwise(points)]
    turns = [_turn(points, runs, i) for i in range(len(points))]
    radii = [radius_m * point.speed**2 for point in points]
    tangents = [
        0.0 if turn == 0 else math.inf if abs(turn) == math.pi else r * math.tan(0.5 * abs(turn))
        for turn, r in zip(turns, radii, strict=True)
    ]
    tight = _tight(points, runs, turns, tangents, radii)
    used = _used(runs, tangents)
    pieces: list[Piece] = []
    legs: list[int] = []
    begins: list[float] = []
    arrived = [points[0].z_m]
    for i, run in enumerate(runs):
        a, b = points[i], points[i + 1]
        breaks = _profile(_left_m(a, arrived[i]), a, b, run, slopes[i], late.on(i, run))
        arrived.append(breaks[-1][1])
        for first, last in pairwise(breaks):
            piece = _straight(a, b, run, first, last, used[i], used[i + 1])
            pieces.append(piece)
            legs.append(i)
            begins.append(max(first[0], used[i]))
        if used[i + 1] > 0:
            before = _climb(breaks[-2], breaks[-1])
            after = _profile(arrived[i + 1], b, points[i + 2], runs[i + 1], slopes[i + 1], late)
            climb = before + _climb(after[0], after[1])
            heading = (b.x_m - a.x_m) / run, (b.y_m - a.y_m) / run
            radius = used[i + 1] / math.tan(0.5 * abs(turns[i + 1]))
            start = pieces[-1].stop if isinstance(pieces[-1], Straight) else pieces[-1].start
            pieces.append(Arc(start, heading, radius, turns[i + 1], used[i + 1] * climb))
            legs.append(i)
            begins.append(run - used[i + 1])
    rows, _ = lay_pieces(pieces, 1.0)
    speed = np.array([points[leg + 1].speed for leg in legs])
    return Track(rows, np.array(legs, int), np.array(begins), speed, arrived, tight, tuple(pieces))


def _turn(points: Sequence[Point], runs: Sequence[float], i: int) -> float:
    """Return the signed turn at a point; pi for a reversal, 0 where no turn is judged."""
    if i in (0, len(points) - 1) or points[i].is_free or not (runs[i - 1] > 0 and runs[i] > 0):
        return 0.0
    before, here, after = points[i - 1 : i + 2]
    ax, ay = here.x_m - before.x_m, here.y_m - before.y_m
    bx, by = after.x_m - here.x_m, after.y_m - here.y_m
    angle = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
    if abs(angle) <= COLLINEAR_RAD:
        return 0.0
    return math.pi if abs(angle) > math.pi - COLLINEAR_RAD else angle


def _tight(
    points: Sequence[Point],
    runs: Sequence[float],
    turns: Sequence[float],
    tangents: Sequence[float],
    radii: Sequence[float],
) -> list[Tight]:
    """Return the turns that do not fit: for each leg that is too short, its sharper turn."""
    worst: dict[int, Tight] = {}
    for leg, run in enumerate(runs):
        needed = tangents[leg] + tangents[leg + 1]
        if needed <= run / _FITS + TOLERANCE_M:
            continue
        point = leg if tangents[leg] > tangents[leg + 1] else leg + 1
        if _is_on_circle(points, runs, turns, point, radii[point]):
            continue
        fitting = radii[point] * run / needed if math.isfinite(needed) else 0.0
        found = Tight(point, leg, needed - run, fitting)
        if point not in worst or found.missing_m > worst[point].missing_m:
            worst[point] = found
    return list(worst.values())


def _is_on_circle(
    points: Sequence[Point], runs: Sequence[float], turns: Sequence[float], i: int, radius_m: float
) -> bool:
    """Return whether a point and its neighbours lie on a circle that the aircraft can follow."""
    before, after = points[i - 1], points[i + 1]
    across = math.hypot(after.x_m - before.x_m, after.y_m - before.y_m)
    circle = across / (2 * abs(math.sin(turns[i]))) if turns[i] % math.pi else 0.0
    longest = max(runs[i - 1], runs[i])
    return circle >= _ROUND * radius_m and longest**2 / (8 * circle) <= _SAGITTA_M


def _used(runs: Sequence[float], tangents: Sequence[float]) -> list[float]:
    """Return the tangents of the arcs that are flown; a turn that does not fit keeps its corner."""
    used = [tangent if math.isfinite(tangent) else 0.0 for tangent in tangents]
    fits = [math.isfinite(tangent) for tangent in tangents]
    for leg, run in enumerate(runs):
        needed = tangents[leg] + tangents[leg + 1]
        if needed > run / _FITS + TOLERANCE_M:
            fits[leg] = fits[leg + 1] = False
        elif needed > run:
            used[leg] *= run / needed
            used[leg + 1] *= run / needed
    return [tangent if each else 0.0 for tangent, each in zip(used, fits, strict=True)]


def _left_m(point: Point, arrived_m: float) -> float:
    """Return the altitude at which a point is left: a circle ends at its own."""
    return arrived_m if point.circle_m is None else point.z_m


def _profile(
    from_m: float, a: Point, to: Point, run_m: float, slopes: Slopes, late: Late
) -> list[tuple[float, float]]:
    """Return distances along a leg with the altitudes there."""
    rise = to.z_m - from_m
    climb, descent = slopes.climb * run_m / to.speed, slopes.descent * run_m / to.speed
    if to.arrival == "gentle" or (to.arrival == "return" and rise <= 0):
        rise = min(max(rise, -descent), climb)
    elif to.arrival == "return":
        rise = min(rise, climb)
        steep_m = rise / slopes.climb * to.speed if slopes.climb > 0 else run_m
        if 0 < steep_m < run_m:
            return [(0.0, from_m), (steep_m, from_m + rise), (run_m, from_m + rise)]
    elif rise > climb:
        late_m = rise - climb
        if late_m <= late.most_m and late_m - max(a.z_m - from_m, 0.0) <= late.leg_m:
            rise = climb
    return [(0.0, from_m), (run_m, from_m + rise)]


def _climb(first: tuple[float, float], last: tuple[float, float]) -> float:
    """Return the slope between two places of a profile."""
    run = last[0] - first[0]
    return (last[1] - first[1]) / run if run > 0 else 0.0


def _straight(
    a: Point,
    b: Point,
    run_m: float,
    first: tuple[float, float],
    last: tuple[float, float],
    cut_first: float,
    cut_last: float,
) -> Straight:
    """Return the part of a leg between two places of its profile, less the turns at its ends."""
    if run_m == 0:
        places = (a.x_m, a.y_m, first[1]), (b.x_m, b.y_m, last[1])
        return Straight(*places, (0.0, 0.0), 0.0, last[1] - first[1])
    east, north = (b.x_m - a.x_m) / run_m, (b.y_m - a.y_m) / run_m
    begin = min(max(first[0], cut_first), last[0])
    end = max(min(last[0], run_m - cut_last), begin)
    climb = _climb(first, last)
    start_m, stop_m = first[1] + climb * (begin - first[0]), first[1] + climb * (end - first[0])
    return Straight(
        (a.x_m + east * begin, a.y_m + north * begin, start_m),
        (a.x_m + east * end, a.y_m + north * end, stop_m),
        (east, north),
        end - begin,
        stop_m - start_m,
    )
