"""Places to fly to, the aircraft as navigation sees it, and its demands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pathgene.sim.autopilot.items import Frame
from pathgene.sim.autopilot.lateral import Motion
from pathgene.sim.autopilot.places import Plane, Vector


__all__ = ["Air", "Approach", "Earth", "Step", "Target"]


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
    climb_m_s : float
        Vertical speed.
    tas_m_s, eas2tas : float
        True airspeed, and its ratio to the equivalent one.
    """

    motion: Motion
    altitude_m: float
    climb_m_s: float
    wind: Vector
    tas_m_s: float
    eas2tas: float
    earth: Earth

    @property
    def place(self) -> Vector:
        """East and north, metres."""
        return self.motion.place


@dataclass(frozen=True)
class Approach:
    """A landing as the height control sees it.

    Parameters
    ----------
    flown : float
        Share of the last leg that has been flown, from 0 to 1.
    above_m : float
        Height above the touch-down.
    eas_m_s : float
        Equivalent airspeed to hold.
    flares : bool
        Whether the flare has begun.
    """

    flown: float
    above_m: float
    eas_m_s: float
    flares: bool


@dataclass(frozen=True)
class Step:
    """Demands of a mission for a tenth of a second.

    Parameters
    ----------
    steer_m_s2 : float
        Acceleration to the right.
    pitch_rad : float or None
        Pitch of a take-off, which height control does not choose.
    throttle : float or None
        Throttle likewise.
    approach : Approach or None
        State of ArduPlane's landing.
    """

    steer_m_s2: float
    height_m: float
    pitch_rad: float | None = None
    throttle: float | None = None
    approach: Approach | None = None
