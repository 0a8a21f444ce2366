"""The flight of a late autopilot along exported waypoints, and the clearance that it keeps.

It decides whether a mission can be handed over. The simulated autopilot, which judges exported
missions, shares no code with it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import JobError
from pathgene.host.mission.autopilot.climbs import SUSTAINED
from pathgene.host.mission.autopilot.early import climb_m_s
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.autopilot.timing import timed, times_of
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain.surface import surface_below


__all__ = ["LateClimbError", "Lowest", "check_climbs", "late_heights", "lowest"]

Floats = NDArray[np.float64]

# Share of the required clearance that a late autopilot must keep.
_SHARE = 0.5
# Height that it may lack, as in the first seconds of a start from the ground.
_TOLERANCE_M = 1.0
# ArduPlane flies a leg that changes its height by less than this as a step (ALT_SLOPE_MIN).
_STEP_BELOW_M = 15.0
_PERIOD_S = 0.25
# Distance beside the legs at which the surface counts, too.
_BESIDE_M = 10.0


class LateClimbError(JobError):
    """A mission that climbs too late for its clearance, so that it has no flight plan.

    Parameters
    ----------
    raise_m : int
        Height by which a higher start would mend it.
    """

    def __init__(self, text: str, raise_m: int) -> None:
        super().__init__(text)
        self.raise_m = raise_m


@dataclass(frozen=True)
class Lowest:
    """The place where a late autopilot lacks most of half of the required clearance.

    Parameters
    ----------
    x_m, y_m : float
        The place, in the terrain's local frame.
    clearance_m, required_m : float
        Height over the surface, and the one that is required.
    """

    x_m: float
    y_m: float
    clearance_m: float
    required_m: float

    @property
    def missing_m(self) -> float:
        """Height that is missing to half of the required clearance."""
        return _SHARE * self.required_m - self.clearance_m


def check_climbs(problem: Problem, points: Sequence[RoutePoint]) -> None:
    """Check that a late autopilot keeps half of the clearance that is required everywhere.

    Raises
    ------
    LateClimbError
        If it does not.
    """
    found = lowest(problem, points)
    if found is None or found.missing_m <= _TOLERANCE_M:
        return
    missing_m = math.ceil(found.missing_m)
    side = "over" if found.clearance_m >= 0 else "below"
    raise LateClimbError(
        f"An autopilot that climbs late flies {abs(found.clearance_m):.0f} m {side} the ground at "
        f"x {found.x_m:.0f} m, y {found.y_m:.0f} m, where {found.required_m:.0f} m over it are "
        f"required, because {_reason(problem)}; start {missing_m} m higher, or plan a way with "
        "more room to climb.",
        missing_m,
    )


def _reason(problem: Problem) -> str:
    late = f"it follows the heights {problem.aircraft.height_lag_s:g} s late"
    return f"{late} and holds less than the steepest climb in gusts" if any(problem.wind) else late


def late_heights(
    times: Floats, heights: Floats, at_s: Floats, lag_s: float, most_m_s: float
) -> Floats:
    """Return the lowest heights of an autopilot that follows waypoints late.

    It asks for the lower of the line between two waypoints and, where that line is too flat for a
    slope, the height of the second one; it climbs no faster than a rate, and is late by the lag.

    Parameters
    ----------
    times, heights : (k,) float64
        Instants and heights of the waypoints.
    at_s : (n,) float64
        Instants of the result, at equal intervals, from the start on.
    """
    asked = np.interp(at_s, times, heights)
    leg = _leg(times, at_s)
    is_step = np.abs(heights[leg] - heights[leg - 1]) < _STEP_BELOW_M
    asked = np.where(is_step, np.minimum(asked, heights[leg]), asked)
    period_s = float(at_s[1] - at_s[0]) if len(at_s) > 1 else 0.0
    share = 1.0 - math.exp(-period_s / lag_s) if lag_s else 1.0
    most_m = most_m_s * period_s
    limited = late = float(heights[0])
    made = []
    for wanted in asked.tolist():
        limited = min(wanted, limited + most_m)
        late += share * (limited - late)
        made.append(late)
    return np.array(made)


def lowest(problem: Problem, points: Sequence[RoutePoint]) -> Lowest | None:
    """Return where a late autopilot lacks most of the clearance; None if none is required.

    In wind it holds :data:`SUSTAINED` of the aircraft's climb, in calm air all of it.
    """
    if problem.rules is None or not problem.rules.clearance_m:
        return None
    aircraft = problem.aircraft
    times = times_of(timed(points, aircraft.cruise_speed_m_s, problem.wind))
    x, y, z = np.array([(point.x_m, point.y_m, point.z_m) for point in points]).T
    at_s = np.arange(0.0, times[-1], _PERIOD_S)
    most_m_s = climb_m_s(problem) * (SUSTAINED if any(problem.wind) else 1.0)
    late_m = late_heights(times, z, at_s, aircraft.height_lag_s, most_m_s)
    east, north = np.interp(at_s, times, x), np.interp(at_s, times, y)
    ways = np.diff(np.column_stack((x, y)), axis=0)
    ways *= _BESIDE_M / np.maximum(np.hypot(*ways.T), 1e-9)[:, None]
    side_x, side_y = ways[_leg(times, at_s) - 1].T
    surface_m = np.maximum.reduce(
        [
            # The rules judge the planned track beside unknown ground.
            surface_below(
                problem.terrain, east - turn * side_y, north + turn * side_x, void_m=-math.inf
            )
            for turn in (-1, 0, 1)
        ]
    )
    required_m = problem.demand.required_m(east, north)
    clearance_m = late_m - surface_m
    worst = int(np.argmax(_SHARE * required_m - clearance_m))
    if not math.isfinite(clearance_m[worst]):
        return None
    return Lowest(*(float(each[worst]) for each in (east, north, clearance_m, required_m)))


def _leg(times: Floats, at_s: Floats) -> NDArray[np.intp]:
    """Return for each instant the number of the waypoint that is flown to."""
    return np.clip(np.searchsorted(times, at_s, side="right"), 1, len(times) - 1)
