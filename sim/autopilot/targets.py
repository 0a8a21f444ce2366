"""Places to fly to, and the aircraft as navigation sees it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pathgene.sim.autopilot.items import Frame
from pathgene.sim.autopilot.lateral import Motion
from pathgene.sim.autopilot.places import Plane, Vector


__all__ = ["Air", "Earth", "Target"]


@dataclass(frozen=True)
class Earth:
    """Home, the plane around it, and the ground.

    Parameters
    ----------
    home_m : float
        Altitude of home, AMSL.
    ground : callable
        Returns the altitude of the ground at east and north, metres.
    """

    plane: Plane
    home_m: float
    ground: Callable[[Vector], float]

    def base_m(self, frame: Frame, place: Vector) -> float:
        """Return the altitude AMSL at which heights of a frame begin."""
        if frame == Frame.HOME:
            return self.home_m
        return self.ground(place) if frame == Frame.TERRAIN else 0.0


@dataclass(frozen=True)
class Target:
    """A place to fly to.

    Parameters
    ----------
    z_m : float
        Height in ``frame``.
    radius_m : float
        Radius of the circle around it; 0 leaves it to the autopilot.
    lands : bool
        Whether the leg to it is a landing, whose slope is kept however small it is.
    """

    place: Vector
    z_m: float
    frame: Frame = Frame.AMSL
    radius_m: float = 0.0
    clockwise: bool = True
    lands: bool = False

    def altitude_m(self, earth: Earth, place: Vector) -> float:
        """Return the altitude AMSL to fly at over a place."""
        return earth.base_m(self.frame, place) + self.z_m


@dataclass(frozen=True)
class Air:
    """The aircraft as navigation sees it.

    Parameters
    ----------
    wind : (float, float)
        Velocity of the air over ground, m/s.
    tas_m_s, eas2tas : float
        True airspeed, and its ratio to the equivalent one.
    """

    motion: Motion
    altitude_m: float
    wind: Vector
    tas_m_s: float
    eas2tas: float
    earth: Earth

    @property
    def place(self) -> Vector:
        """East and north, metres."""
        return self.motion.place
