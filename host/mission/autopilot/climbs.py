"""Heights for an autopilot that climbs late: each climb begins earlier by its lag."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.mission.autopilot.timing import Timed, times_of


__all__ = ["led"]

Floats = NDArray[np.float64]

# Height that a leg may lie below the heights that it has to keep.
_BELOW_M = 1.0
# Acceptance radius of an inserted waypoint, on whose leg the heading does not change.
_ON_LEG_M = 10


@dataclass(frozen=True)
class _Asked:
    """Heights to ask for: the maximum planned height from an instant until the lag has passed."""

    times: Floats
    heights: Floats
    lag_s: float

    def __call__(self, t: float) -> float:
        until = t + self.lag_s
        within = self.heights[(self.times > t) & (self.times < until)]
        ends = np.interp([t, until], self.times, self.heights)
        return float(np.max(np.concatenate((within, ends))))

    @property
    def breaks(self) -> list[float]:
        """Instants between the ends at which the heights may change their slope."""
        times = np.concatenate((self.times, self.times - self.lag_s)).tolist()
        return sorted({t for t in times if 0 < t < self.times[-1]})


def led(
    kept: Sequence[Timed], planned: Sequence[Timed], lag_s: float, apart_s: float
) -> list[RoutePoint]:
    """Return waypoints whose heights a late autopilot keeps.

    An autopilot that is late by the lag is then never below the plan in climbs, and above it in
    descents. Waypoints are inserted where the heights need them. Start and goal keep their heights.

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
    """
    times = times_of(planned)
    asked = _Asked(times, np.array([each.point.z_m for each in planned]), lag_s)
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
        if wanted - z <= _BELOW_M:
            continue
        if min(t - before.t_s, after.t_s - t) >= apart_s:
            made.insert(at, Timed(t, RoutePoint(x, y, wanted, _ON_LEG_M)))
            continue
        # A neighbour is too near for another waypoint, so it is raised; ends keep their heights.
        near = at if after.t_s - t <= t - before.t_s else at - 1
        near = min(max(near, 1), len(made) - 2)
        if near >= 1:
            raised = replace(made[near].point, z_m=max(made[near].point.z_m, wanted))
            made[near] = Timed(made[near].t_s, raised)
    return [each.point for each in made]


def _place(point: RoutePoint) -> tuple[float, float, float]:
    return point.x_m, point.y_m, point.z_m
