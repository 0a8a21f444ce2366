"""The waypoints of a track that an autopilot flies as planned, as few as possible."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.mission.autopilot.climbs import SUSTAINED
from pathgene.host.mission.autopilot.early import climb_m_s, early, is_too_high
from pathgene.host.mission.autopilot.route import RoutePoint, leg_tolerance_m, route
from pathgene.host.mission.autopilot.spacing import accepted, spaced
from pathgene.host.mission.autopilot.steps import stepped
from pathgene.host.mission.autopilot.thinning import RAISED_M, thinned
from pathgene.host.mission.autopilot.timing import Timed, timed, times_of
from pathgene.host.problem.problem import Problem


__all__ = ["apart_m", "flyable"]

# Minimum time between two waypoints.
_APART_S = 1.1
# Time that the aircraft needs to begin a turn.
_ROLL_S = 0.3
# Trials to leave out waypoints, each with more of them kept.
_TRIALS = 12
# Number of the heights of waypoints above given ones, up to 10 m, that are tried second.
_LOW = 6
# Metres by which a limit may be broken for longer, which are rounding.
_SAME_M = 1e-3


def flyable(problem: Problem, track: SmoothedTrack, simplify_m: float) -> list[RoutePoint]:
    """Return the waypoints of a track that an autopilot flies as planned.

    Parameters
    ----------
    simplify_m : float
        Maximum distance of a leg from the legs that touch the track. It is less where a limit
        would be broken that these keep.
    """
    corridor_m = None if problem.rules is None else problem.rules.corridor_m
    points = route(track, leg_tolerance_m(corridor_m))
    planned = timed(points, problem.aircraft.cruise_speed_m_s, problem.wind)
    kept = early(problem, spaced(planned, apart_m(problem)), planned, _APART_S)
    for few in _trials(problem, kept, simplify_m):
        made = stepped(few, kept, _APART_S)
        if not is_too_high(problem, planned, made, with_steps=True):
            break
    else:
        made = kept
    roll_m = _ROLL_S * problem.aircraft.cruise_speed_m_s
    return accepted([each.point for each in made], roll_m)


def apart_m(problem: Problem) -> float:
    """Return the minimum distance of two waypoints, in a tail wind."""
    return _APART_S * (problem.aircraft.cruise_speed_m_s + math.hypot(*problem.wind))


def _trials(
    problem: Problem, points: Sequence[Timed], simplify_m: float
) -> Iterator[Sequence[Timed]]:
    """Yield waypoints that break no limit for longer than all of them do, the fewest first.

    All are kept where the track begins before the start, in a turn from the heading there.
    """
    ends = zip((points[0], points[-1]), (problem.start, problem.goal), strict=True)
    is_away = any(math.dist(_place(each), end) > _SAME_M for each, end in ends)
    if simplify_m and not is_away:
        # Lower legs keep some limits that higher ones break.
        for raised_m in (RAISED_M, RAISED_M[:_LOW]):
            few = _fewest(problem, points, simplify_m, raised_m)
            if few is not None:
                yield few
    yield points


def _fewest(
    problem: Problem, points: Sequence[Timed], simplify_m: float, raised_m: Sequence[float]
) -> list[Timed] | None:
    """Return waypoints that break no limit for longer than all of them do, or None."""
    evaluator = Evaluator(problem, threads=1)
    allowed = _broken(evaluator, points)
    pinned: set[int] = set()
    for _ in range(_TRIALS):
        made = thinned(points, simplify_m, SUSTAINED * climb_m_s(problem), pinned, raised_m)
        broken = _broken(evaluator, made)
        worse = [
            place
            for limit, spans in broken.items()
            if _metres(spans) > _metres(allowed.get(limit, ())) + _SAME_M
            for span in spans
            for place in span
        ]
        if not worse:
            return made
        more = _around(points, made, worse)
        if more <= pinned:
            break
        pinned |= more
    return None


def _broken(evaluator: Evaluator, points: Sequence[Timed]) -> dict[str, list[tuple[float, float]]]:
    """Return the stretches that break each limit, metres flown."""
    path = np.array([_place(each) for each in points])
    found: dict[str, list[tuple[float, float]]] = {}
    for each in evaluator.broken(path):
        found.setdefault(each.limit, []).append((each.from_m, each.to_m))
    return found


def _place(each: Timed) -> tuple[float, float, float]:
    return each.point.x_m, each.point.y_m, each.point.z_m


def _metres(spans: Sequence[tuple[float, float]]) -> float:
    return sum(stop - start for start, stop in spans)


def _around(points: Sequence[Timed], made: Sequence[Timed], at_m: Sequence[float]) -> set[int]:
    """Return the numbers of the waypoints before and after places, metres along fewer legs."""
    place = np.array([_place(each) for each in made])
    flown = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(place, axis=0), axis=1))))
    found: set[int] = set()
    for t in np.interp(at_m, flown, times_of(made)):
        after = int(np.searchsorted(times_of(points), t))
        found |= {after - 1, after}
    return found
