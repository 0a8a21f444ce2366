"""The flight of a mission: its points in flying order, in the frame of a terrain."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Literal


__all__ = ["Arrival", "Chain", "Handle", "Point", "moved", "without"]

#: Part of a mission that a remedy may change: an item by its number, a rally point, or the height
#: of the return.
Handle = tuple[Literal["item", "rally", "return"], int]

#: Height along the leg to a point: linear; linear up to the steepest slope, which a circle then
#: completes; or the steepest climb first, as on the return to launch.
Arrival = Literal["linear", "gentle", "return"]


@dataclass(frozen=True)
class Point:
    """A point of a flight.

    Parameters
    ----------
    x_m, y_m, z_m : float
        Position in the terrain's frame, and altitude.
    name : str
        Name in sentences, such as ``item 6`` or ``home``.
    handle : tuple, optional
        Part of the mission that states its height; None if none does.
    arrival : str
        Height along the leg to it.
    speed : float
        Airspeed as a multiple of the aircraft's cruise speed, 1 or more.
    circle_m : float, optional
        Radius of the circle that is flown around it; None for a turn.
    asked_m : float, optional
        Radius that the mission asks for, where that is below ``circle_m``.
    is_free : bool
        The turn at it is not judged: it is a circle, or the place of a take-off or landing.
    is_ground : bool
        The aircraft stands there before the take-off, or after the landing.
    """

    x_m: float
    y_m: float
    z_m: float
    name: str
    handle: Handle | None = None
    arrival: Arrival = "linear"
    speed: float = 1.0
    circle_m: float | None = None
    asked_m: float | None = None
    is_free: bool = False
    is_ground: bool = False

    @property
    def place(self) -> tuple[float, float, float]:
        """Position and altitude."""
        return self.x_m, self.y_m, self.z_m


@dataclass(frozen=True)
class Chain:
    """Points that are flown in their order.

    Parameters
    ----------
    points : tuple of Point
        One or more.
    starts_low : bool
        Less clearance is required near the first point, as it always is near the end.
    returns : bool
        The last leg is a return to launch; the end of the chain is the point before it.
    """

    points: tuple[Point, ...]
    starts_low: bool = True
    returns: bool = False

    @property
    def end(self) -> Point:
        """The last point, or the point before a return."""
        return self.points[-2 if self.returns and len(self.points) > 1 else -1]


def moved(
    chains: Iterable[Chain],
    handles: frozenset[Handle],
    east_m: float = 0.0,
    north_m: float = 0.0,
    up_m: float = 0.0,
) -> tuple[Chain, ...]:
    """Return a flight in which the points of some handles are moved."""

    def change(point: Point) -> Point:
        return replace(point, x_m=point.x_m + east_m, y_m=point.y_m + north_m, z_m=point.z_m + up_m)

    return tuple(_changed(chain, handles, change) for chain in chains)


def without(chains: Iterable[Chain], handle: Handle) -> tuple[Chain, ...]:
    """Return a flight without the points of a handle; a chain keeps one point or more."""
    found = (
        replace(chain, points=tuple(each for each in chain.points if each.handle != handle))
        for chain in chains
    )
    return tuple(chain for chain in found if chain.points)


def _changed(chain: Chain, handles: frozenset[Handle], change: Callable[[Point], Point]) -> Chain:
    points = (change(each) if each.handle in handles else each for each in chain.points)
    return replace(chain, points=tuple(points))
