"""Lateral guidance of PX4: non-linear path following with the wind in its equations.

The law of Stastny and Siegwart, "On Flying Backwards: Preventing Run-away of Small, Low-speed,
Fixed-wing UAVs in Strong Winds" (2019), with the period and damping of PX4's parameters
``NPFG_PERIOD`` and ``NPFG_DAMPING``. The airspeed stays nominal; its increase in excess wind is
left out.
"""

from __future__ import annotations

import math

from pathgene.sim.autopilot.places import Vector, cross, dot


__all__ = ["Npfg"]

# The shortest period is this multiple of the one that the roll loop allows.
_SAFETY = 1.5


class Npfg:
    """The lateral law.

    Parameters
    ----------
    period_s, damping, roll_s : float
        ``NPFG_PERIOD``, ``NPFG_DAMPING`` and ``NPFG_ROLL_TC``.

    Attributes
    ----------
    error_bound_m : float
        Distance from the path at which the aircraft flies straight towards it.
    """

    def __init__(self, period_s: float, damping: float, roll_s: float) -> None:
        self._period_s = max(period_s, _SAFETY * math.pi * roll_s / damping)
        self._damping = damping
        self.error_bound_m = 0.0
        self.crosstrack_m = 0.0

    def steer(
        self, velocity: Vector, wind: Vector, tangent: Vector, error_m: float, curvature: float
    ) -> float:
        """Return the acceleration to the right, m/s^2.

        Parameters
        ----------
        velocity, wind : (float, float)
            Velocity over ground and of the air, m/s.
        tangent : (float, float)
            Unit vector of the path at its nearest point.
        error_m : float
            Distance from the path, positive to its right.
        curvature : float
            Curvature of the path, positive to the right, 1/m.
        """
        self.crosstrack_m = error_m
        air = (velocity[0] - wind[0], velocity[1] - wind[1])
        airspeed = max(math.hypot(*air), 1e-3)
        time_s = self._period_s * self._damping
        ground_speed = math.hypot(*velocity)
        if ground_speed > 1:
            self.error_bound_m = ground_speed * time_s
        else:
            self.error_bound_m = 0.5 * time_s * (ground_speed**2 + 1)
        share = min(abs(error_m) / self.error_bound_m, 1.0)
        look = 0.5 * math.pi * (share - 1) ** 2
        side = -1.0 if error_m >= 0 else 1.0
        right = (tangent[1], -tangent[0])
        bearing = (
            math.cos(look) * side * right[0] + math.sin(look) * tangent[0],
            math.cos(look) * side * right[1] + math.sin(look) * tangent[1],
        )
        wanted = _air_velocity(bearing, wind, airspeed)
        gain = 4 * math.pi * self._damping / self._period_s
        turn = cross(air, wanted) / airspeed
        if dot(air, wanted) < 0:
            turn = math.copysign(airspeed, turn)
        followed = math.sin(look) ** 2 * _along(velocity, wind, tangent, error_m, curvature)
        return gain * turn + followed


def _air_velocity(bearing: Vector, wind: Vector, airspeed: float) -> Vector:
    """Return the velocity through the air whose ground track has a bearing, or nearly."""
    across = cross(bearing, wind)
    along = math.sqrt(max(airspeed**2 - across**2, 0.0))
    right = (bearing[1], -bearing[0])
    east = along * bearing[0] - across * right[0]
    north = along * bearing[1] - across * right[1]
    length = max(math.hypot(east, north), 1e-9)
    return east * airspeed / length, north * airspeed / length


def _along(
    velocity: Vector, wind: Vector, tangent: Vector, error_m: float, curvature: float
) -> float:
    """Return the acceleration that follows the curvature of the path."""
    if not curvature:
        return 0.0
    air = (velocity[0] - wind[0], velocity[1] - wind[1])
    airspeed = math.hypot(*air)
    rate = curvature / max(1 - curvature * error_m, 1e-3) * dot(velocity, tangent)
    across = cross(tangent, wind)
    forward = math.sqrt(max(airspeed**2 - across**2, 1e-6))
    return airspeed * (1 + dot(wind, tangent) / forward) * rate
