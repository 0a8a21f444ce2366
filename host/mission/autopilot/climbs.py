"""Heights for an autopilot that climbs late: each climb begins earlier by its lag and reserve."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.autopilot.timing import Timed, times_of


__all__ = ["SUSTAINED", "led"]

Floats = NDArray[np.float64]

#: Share of the aircraft's climb that an autopilot holds for minutes in gusts. ArduPlane lowers its
#: own limit each time that an error of height asks for more than the limit.
SUSTAINED = 0.75
# Height that a leg may lie below the heights that it has to keep, and above them.
_BELOW_M, _ABOVE_M = 1.0, 15.0
# Acceptance radius of an inserted waypoint, on whose leg the heading does not change.
_ON_LEG_M = 10


@dataclass(frozen=True)
class _Asked:
    """Heights to ask for: the maximum height from an instant until the lag has passed.

    After the start, they rise no faster than an aircraft without a lag can climb.
    """

    times: Floats
    heights: Floats
    start_m: float
    lag_s: float
    climb_m_s: float

    def __call__(self, t: float) -> float:
        return min(self._ahead(t), self._reached(t))

    def _ahead(self, t: float) -> float:
        until = t + self.lag_s
        within = self.heights[(self.times > t) & (self.times < until)]
        ends = np.interp([t, until], self.times, self.heights)
        return float(np.max(np.concatenate((within, ends))))

    def _reached(self, t: float) -> float:
        return self.start_m + self.climb_m_s * (t + self.lag_s)

    @property
    def breaks(self) -> list[float]:
        """Instants between the ends at which the heights may change their slope."""
        times = np.unique(np.concatenate((self.times, self.times - self.lag_s)))
        short = np.array([self._ahead(t) - self._reached(t) for t in times.tolist()])
        crossed = np.flatnonzero((short[:-1] > 0) & (short[1:] <= 0))
        shares = short[crossed] / (short[crossed] - short[crossed + 1])
        reached = times[crossed] + shares * np.diff(times)[crossed]
        every = sorted({*times.tolist(), *reached.tolist()})
        return [t for t in every if 0 < t < self.times[-1]]


def led(
    kept: Sequence[Timed],
    planned: Sequence[Timed],
    lag_s: float,
    apart_s: float,
    climb_m_s: float = math.inf,
) -> list[Timed]:
    """Return waypoints whose heights a late autopilot keeps.

    An autopilot that is late by the lag, and holds :data:`SUSTAINED` of the aircraft's climb, is
    then never below the plan in climbs, and above it in descents. The exception is a climb that
    would have to begin before the start. Waypoints are inserted where the heights need them. Start
    and goal keep their heights.

    Parameters
    ----------
    kept : sequence of Timed
        The waypoints to export.
    planned : sequence of Timed
        The track, which has their places and heights, and more of them.
    lag_s : float
        Delay of the autopilot's height, 0 or more.
    apart_s : float
        Minimum time between an inserted waypoint and its neighbours.
    climb_m_s : float
        Maximum vertical speed of the aircraft.
    """
    heights = np.array([each.point.z_m for each in planned])
    times, heights = _early(times_of(planned), heights, SUSTAINED * climb_m_s)
    asked = _Asked(times, heights, kept[0].point.z_m, lag_s, climb_m_s)
    made = [Timed(each.t_s, replace(each.point, z_m=asked(each.t_s))) for each in kept]
    made[0], made[-1] = kept[0], kept[-1]
    for t in sorted({*asked.breaks, min(apart_s, times[-1])}):
        wanted = asked(t)
        at = next(number for number, each in enumerate(made) if each.t_s >= t)
        before, after = made[max(at - 1, 0)], made[at]
        share = (t - before.t_s) / (after.t_s - before.t_s) if after.t_s > before.t_s else 1.0
        x, y, z = (
            a + share * (b - a)
            for a, b in zip(_place(before.point), _place(after.point), strict=True)
        )
        if -_ABOVE_M <= wanted - z <= _BELOW_M:
            continue
        if min(t - before.t_s, after.t_s - t) >= apart_s:
            made.insert(at, Timed(t, RoutePoint(x, y, wanted, _ON_LEG_M)))
            continue
        if wanted < z:
            continue
        # A neighbour is too near for another waypoint, so it is raised; ends keep their heights.
        near = at if after.t_s - t <= t - before.t_s else at - 1
        near = min(max(near, 1), len(made) - 2)
        if near >= 1:
            raised = replace(made[near].point, z_m=max(made[near].point.z_m, wanted))
            made[near] = Timed(made[near].t_s, raised)
    return made


def _early(times: Floats, heights: Floats, climb_m_s: float) -> tuple[Floats, Floats]:
    """Return the lowest profile above another one that climbs no faster than a rate."""
    made = [(float(times[-1]), float(heights[-1]))]
    low_m = made[0][1]
    for t, height_m in zip(times[-2::-1].tolist(), heights[-2::-1].tolist(), strict=True):
        after_s, after_m = made[-1]
        needed_m = after_m - climb_m_s * (after_s - t) if after_s > t else after_m
        if needed_m < height_m and low_m < after_m:
            # The climb meets the profile between the two instants.
            share = (height_m - needed_m) / (height_m - needed_m + after_m - low_m)
            meets_s = t + share * (after_s - t)
            made.append((meets_s, after_m - climb_m_s * (after_s - meets_s)))
        made.append((t, max(height_m, needed_m)))
        low_m = height_m
    early_s, early_m = np.array(made[::-1]).T
    return early_s, early_m


def _place(point: RoutePoint) -> tuple[float, float, float]:
    return point.x_m, point.y_m, point.z_m
