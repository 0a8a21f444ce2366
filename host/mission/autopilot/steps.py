"""Heights of legs that an autopilot flies as a step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.autopilot.timing import Timed, times_of


__all__ = ["STEP_M", "stepped"]

#: Change of height below which ArduPlane flies a leg as a step (``ALT_SLOPE_MIN``,
#: ``GLIDE_SLOPE_MIN`` in earlier versions), with its rounding to centimetres.
STEP_M = 15.05
# Height that a step may lie below the given legs.
_BELOW_M = 1.0
# Acceptance radius of an inserted waypoint, on whose leg the heading does not change.
_ON_LEG_M = 10


def stepped(points: Sequence[Timed], low: Sequence[Timed], apart_s: float) -> list[Timed]:
    """Return waypoints whose heights are kept on legs that are flown as a step, too.

    ArduPlane goes to the height of the next waypoint at once if the leg changes the height by less
    than :data:`STEP_M`. So the end of a leg that goes down by less is raised to the maximum height
    that the leg has to keep. The goal stays; a waypoint before it keeps the height until there.

    Parameters
    ----------
    points : sequence of Timed
        The waypoints.
    low : sequence of Timed
        Waypoints with the heights to keep, of the same way.
    apart_s : float
        Minimum time between an inserted waypoint and its neighbours.
    """
    times, heights = times_of(low), np.array([each.point.z_m for each in low])

    def needed_m(start_s: float, stop_s: float) -> float:
        ends = np.interp([start_s, stop_s], times, heights)
        within = heights[(times > start_s) & (times < stop_s)]
        return float(np.max(np.concatenate((ends, within)))) - _BELOW_M

    made = [points[0]]
    for each in points[1:]:
        before = made[-1]
        short_m = needed_m(before.t_s, each.t_s) - each.point.z_m
        if abs(each.point.z_m - before.point.z_m) < STEP_M and short_m > 0:
            if each is not points[-1]:
                each = _at(each, each.point.z_m + short_m)
            elif each.t_s - before.t_s >= 2 * apart_s:
                t = each.t_s - apart_s
                made.append(Timed(t, _between(before, each, t, needed_m(before.t_s, t))))
        made.append(each)
    return made


def _at(each: Timed, z_m: float) -> Timed:
    return replace(each, point=replace(each.point, z_m=z_m))


def _between(before: Timed, after: Timed, t_s: float, z_m: float) -> RoutePoint:
    """Return a waypoint on a leg."""
    share = (t_s - before.t_s) / (after.t_s - before.t_s)
    a, b = before.point, after.point
    x_m, y_m = a.x_m + share * (b.x_m - a.x_m), a.y_m + share * (b.y_m - a.y_m)
    return RoutePoint(x_m, y_m, z_m, _ON_LEG_M)
