"""The aircraft of the simulated autopilot: its state, its sensors, and its next step."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pathgene.sim.autopilot import dynamics
from pathgene.sim.autopilot.airframe import Airframe, density, eas2tas
from pathgene.sim.autopilot.places import Vector
from pathgene.sim.autopilot.wind import Wind


__all__ = ["PERIOD_S", "Loops", "Vehicle"]

#: Seconds between two calls of :meth:`Vehicle.step`: the autopilot navigates ten times a second.
PERIOD_S = 0.1


@dataclass(frozen=True)
class Loops:
    """The attitude loops: time constants in seconds and maximum rates, rad/s (0: no limit)."""

    roll_s: float
    pitch_s: float
    roll_rate_rad_s: float = 0.0
    pitch_rate_rad_s: float = 0.0


class Vehicle:
    """A point mass with bank and pitch.

    Parameters
    ----------
    place : (float, float, float)
        East and north in metres, altitude AMSL.
    heading_rad : float
        Clockwise from north.
    airspeed_m_s : float
        True airspeed.
    """

    def __init__(
        self,
        airframe: Airframe,
        loops: Loops,
        wind: Wind,
        *,
        place: tuple[float, float, float],
        heading_rad: float,
        airspeed_m_s: float,
        climb_m_s: float = 0.0,
    ) -> None:
        self.airframe = airframe
        self._loops = loops
        self._wind = wind.samples()
        self._gust = self._wind.next()
        made = airframe
        self._figures = np.array(
            [
                *(made.mass_kg, made.wing_area_m2, made.lift_zero, made.lift_slope, made.lift_max),
                *(made.drag_zero, made.induced, made.thrust_N, made.power_W),
                *(made.side_force, made.turn_slip_m, made.roll_lag_s, made.pitch_lag_s),
            ]
        )
        level = math.sqrt(max(airspeed_m_s**2 - climb_m_s**2, 0.0))
        east = level * math.sin(heading_rad) + self._gust[-1, 0]
        north = level * math.cos(heading_rad) + self._gust[-1, 1]
        self._state = np.array([*place, east, north, climb_m_s, *(0.0,) * 5])
        pressure = 0.5 * density(place[2]) * airspeed_m_s**2 * made.wing_area_m2
        lift = made.mass_kg * 9.80665 / max(pressure, 1e-6)
        alpha = (min(lift, made.lift_max) - made.lift_zero) / made.lift_slope
        self._state[8] = alpha + math.atan2(climb_m_s, max(level, 0.1))
        drag = pressure * (made.drag_zero + made.induced * lift**2)
        self._state[10] = min(drag / made.thrust_N, 1.0)
        self._acceleration = (0.0, 0.0, 0.0)

    @property
    def place(self) -> Vector:
        """East and north, metres."""
        return float(self._state[0]), float(self._state[1])

    @property
    def altitude_m(self) -> float:
        """Altitude AMSL."""
        return float(self._state[2])

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Velocity over ground east, north and up, m/s."""
        return float(self._state[3]), float(self._state[4]), float(self._state[5])

    @property
    def roll_rad(self) -> float:
        """Bank, positive to the right."""
        return float(self._state[6])

    @property
    def pitch_rad(self) -> float:
        """Pitch, positive up."""
        return float(self._state[8])

    @property
    def throttle(self) -> float:
        """Throttle from 0 to 1."""
        return float(self._state[10])

    @property
    def _through_air(self) -> tuple[float, float, float]:
        east, north, up = self._state[3:6] - self._gust[-1]
        return float(east), float(north), float(up)

    @property
    def tas_m_s(self) -> float:
        """True airspeed."""
        return math.hypot(*self._through_air)

    @property
    def wind(self) -> Vector:
        """Velocity of the air over ground, m/s east and north."""
        return float(self._gust[-1, 0]), float(self._gust[-1, 1])

    @property
    def eas2tas(self) -> float:
        """True airspeed divided by equivalent airspeed at this altitude."""
        return eas2tas(self.altitude_m)

    @property
    def sensed_eas_m_s(self) -> float:
        """Equivalent airspeed that the sensor shows."""
        return self.tas_m_s / math.pow(self.eas2tas, self.airframe.pitot_exponent)

    @property
    def sensed_tas_m_s(self) -> float:
        """True airspeed that the autopilot computes from its sensor."""
        return self.sensed_eas_m_s * self.eas2tas

    @property
    def forward_m_s2(self) -> float:
        """Acceleration along the nose over the last step, as accelerometers show it."""
        (east, north), (ax, ay, az) = self.nose, self._acceleration
        sine, cosine = math.sin(self.pitch_rad), math.cos(self.pitch_rad)
        return cosine * (ax * east + ay * north) + sine * az

    @property
    def nose(self) -> Vector:
        """Unit vector of the heading."""
        east, north, _ = self._through_air
        level = max(math.hypot(east, north), 1e-6)
        return east / level, north / level

    def move(self, place: tuple[float, float, float]) -> None:
        """Continue from another place: east and north in metres, altitude AMSL."""
        self._state[0:3] = place

    def step(self, roll_rad: float, pitch_rad: float, throttle: float) -> None:
        """Fly for :data:`PERIOD_S` seconds with these demands."""
        loops = self._loops
        demand = np.array(
            [
                *(roll_rad, pitch_rad, throttle, loops.roll_s, loops.pitch_s),
                loops.roll_rate_rad_s or math.inf,
                loops.pitch_rate_rad_s or math.inf,
                density(self.altitude_m),
            ]
        )
        self._gust = self._wind.next()
        before = self.velocity
        dynamics.fly(self._state, self._figures, demand, self._gust)
        ax, ay, az = (
            (new - old) / PERIOD_S for new, old in zip(self.velocity, before, strict=True)
        )
        self._acceleration = (ax, ay, az)
