"""Waypoints with the instants at which the aircraft passes them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.mission.autopilot.route import RoutePoint


__all__ = ["Timed", "timed", "times_of"]

# A head wind slows the aircraft over ground to this share of its airspeed at the slowest.
_SLOWEST = 0.25


@dataclass(frozen=True)
class Timed:
    """A waypoint and the seconds from the start to it."""

    t_s: float
    point: RoutePoint


def timed(
    points: Sequence[RoutePoint], airspeed_m_s: float, wind_m_s: tuple[float, float]
) -> list[Timed]:
    """Return waypoints with their times, at a constant airspeed in a constant wind."""
    legs = np.diff([(point.x_m, point.y_m) for point in points], axis=0)
    lengths = np.hypot(*legs.T)
    along = legs @ np.array(wind_m_s) / np.maximum(lengths, 1e-9)
    seconds = lengths / np.maximum(airspeed_m_s + along, _SLOWEST * airspeed_m_s)
    times = [0.0, *np.cumsum(seconds).tolist()]
    return [Timed(t, point) for t, point in zip(times, points, strict=True)]


def times_of(points: Sequence[Timed]) -> NDArray[np.float64]:
    """Return the instants of waypoints."""
    return np.array([each.t_s for each in points])
