"""The aircraft as the pilot sees it, so that another flight model can take its place."""

from __future__ import annotations

from typing import Protocol

from pathgene.sim.autopilot.places import Vector


__all__ = ["Craft"]


class Craft(Protocol):
    """State and sensors of an aircraft; see :class:`~pathgene.sim.autopilot.vehicle.Vehicle`."""

    @property
    def place(self) -> Vector:
        """East and north of home, metres."""

    @property
    def altitude_m(self) -> float:
        """Altitude AMSL."""

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Velocity over ground east, north and up, m/s."""

    @property
    def nose(self) -> Vector:
        """Unit vector of the heading."""

    @property
    def roll_rad(self) -> float:
        """Bank, positive to the right."""

    @property
    def pitch_rad(self) -> float:
        """Pitch, positive up."""

    @property
    def throttle(self) -> float:
        """Throttle from 0 to 1."""

    @property
    def wind(self) -> Vector:
        """Velocity of the air over ground, m/s east and north."""

    @property
    def eas2tas(self) -> float:
        """True airspeed divided by equivalent airspeed at this altitude."""

    @property
    def sensed_eas_m_s(self) -> float:
        """Equivalent airspeed that the sensor shows."""

    @property
    def sensed_tas_m_s(self) -> float:
        """True airspeed that the autopilot computes from its sensor."""

    @property
    def forward_m_s2(self) -> float:
        """Acceleration along the nose over the last step."""

    def step(self, roll_rad: float, pitch_rad: float, throttle: float) -> None:
        """Fly for a tenth of a second with these demands."""
