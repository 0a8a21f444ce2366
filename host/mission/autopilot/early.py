"""Early climbs under the ceilings and the zones that a plan passes below."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pathgene.host.mission.autopilot.climbs import led
from pathgene.host.mission.autopilot.steps import STEP_M
from pathgene.host.mission.autopilot.timing import Timed, times_of
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain.surface import surface_below


__all__ = ["climb_m_s", "early", "is_too_high"]

# Time between two places at which heights are compared with limits above them.
_PERIOD_S = 0.5


def climb_m_s(problem: Problem) -> float:
    """Return the maximum vertical speed of a problem's aircraft."""
    return problem.aircraft.cruise_speed_m_s * math.sin(max(problem.limits.climb_rad, 0.0))


def early(
    problem: Problem, kept: Sequence[Timed], planned: Sequence[Timed], apart_s: float
) -> list[Timed]:
    """Return waypoints whose climbs begin early enough for a late autopilot.

    If the higher waypoints would exceed the ceiling above the ground, or enter a zone that the plan
    passes below, climbs begin earlier by the lag alone, or where they are planned.

    Parameters
    ----------
    kept, planned, apart_s
        As for :func:`pathgene.host.mission.autopilot.climbs.led`.
    """
    lag_s = problem.aircraft.height_lag_s
    for lag, climb in ((lag_s, climb_m_s(problem)), (lag_s, math.inf)):
        made = led(kept, planned, lag, apart_s, climb)
        if not is_too_high(problem, planned, made):
            break
    else:
        made = led(kept, planned, 0.0, apart_s)
    return made


def is_too_high(
    problem: Problem,
    planned: Sequence[Timed],
    made: Sequence[Timed],
    *,
    with_steps: bool = False,
) -> bool:
    """Return whether waypoints pass a limit above them that the plan keeps.

    Parameters
    ----------
    with_steps : bool
        Judge legs that change the height by less than a step at their higher end, too.
    """
    rules = problem.rules
    ceiling_m = None if rules is None else rules.ceiling_agl_m
    floors = [(each, each.lower_m) for each in problem.zones if each.lower_m is not None]
    if ceiling_m is None and not floors:
        return False
    times = times_of(planned)
    at_s = np.arange(0.0, times[-1], _PERIOD_S)
    x, y, low = (
        np.interp(at_s, times, values)
        for values in np.array([(p.point.x_m, p.point.y_m, p.point.z_m) for p in planned]).T
    )
    heights = np.array([each.point.z_m for each in made])
    high = np.interp(at_s, times_of(made), heights)
    if with_steps:
        leg = np.clip(np.searchsorted(times_of(made), at_s), 1, len(made) - 1)
        steps = np.abs(np.diff(heights)) < STEP_M
        tops = np.maximum(heights[1:], heights[:-1])
        high = np.where(steps[leg - 1], tops[leg - 1], high)
    if ceiling_m is not None:
        top_m = surface_below(problem.terrain, x, y) + ceiling_m
        if ((high > top_m) & (low <= top_m)).any():
            return True
    margin_m = 0.0 if rules is None else rules.zone_margin_m
    for zone, floor_m in floors:
        raised = (high + margin_m >= floor_m) & (low + margin_m < floor_m)
        if raised.any() and (zone.footprint.distance_m(x[raised], y[raised]) <= margin_m).any():
            return True
    return False
