"""Ways of an autopilot beyond a planned path: a turn and a straight leg after it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.mission.autopilot.room import CORNER_M
from pathgene.host.mission.autopilot.route import RoutePoint
from pathgene.host.problem.problem import Problem


__all__ = ["STEP_M", "Way", "flown", "ways_to"]

Floats = NDArray[np.float64]

# Maximum turn at a waypoint, which lies the further outside the arc the wider its turn is.
_WIDEST_RAD = math.radians(120)
# Half of a corner's turn up to which the first corner, which is near to the start, is left out.
_SMALL_RAD = math.radians(6)
# Acceptance radius of the last waypoint before the circle.
_ON_WAY_M = 10
#: Points along a way are this far apart, metres, where that is not too many.
STEP_M = 10.0
# Maximum number of points along a way that are compared with the surface.
_MOST_POINTS = 600


@dataclass(frozen=True)
class Way:
    """An arc and a straight way after it, from the goal or from another place.

    Parameters
    ----------
    start : (float, float, float)
        Its beginning: x, y and altitude.
    heading : (float, float)
        Unit vector of the heading there.
    radius_m, turn_rad : float
        The arc, which turns to the left if ``turn_rad`` is positive.
    straight_m : float
        Length of the straight way.
    apart_m : float
        Minimum distance of two waypoints.
    """

    start: tuple[float, float, float]
    heading: tuple[float, float]
    radius_m: float
    turn_rad: float
    straight_m: float
    apart_m: float

    @property
    def arc_m(self) -> float:
        """Length of the arc."""
        return self.radius_m * abs(self.turn_rad)

    @property
    def length_m(self) -> float:
        """Length of the whole way."""
        return self.arc_m + self.straight_m

    def at(self, along_m: Floats, outwards: float = 1.0) -> tuple[Floats, Floats, Floats, Floats]:
        """Return places and headings after distances; ``outwards`` multiplies the arc's radius."""
        x, y, _ = self.start
        east, north = self.heading
        side = math.copysign(self.radius_m, self.turn_rad)
        angle = np.minimum(along_m, self.arc_m) / side
        to_east = east * np.cos(angle) - north * np.sin(angle)
        to_north = north * np.cos(angle) + east * np.sin(angle)
        beyond = np.maximum(along_m - self.arc_m, 0.0)
        centre_x, centre_y = x - side * north, y + side * east
        return (
            centre_x + outwards * side * to_north + beyond * to_east,
            centre_y - outwards * side * to_east + beyond * to_north,
            to_east,
            to_north,
        )

    def beyond(self, distance_m: float) -> tuple[float, float]:
        """Return the place straight ahead of the end."""
        x, y, *_ = self.at(np.array([self.length_m + distance_m]))
        return float(x[0]), float(y[0])

    def points(self, lead_m: float, end_m: float, *, is_gusty: bool) -> Iterator[RoutePoint]:
        """Yield the waypoints of the way, which asks for its last height ``lead_m`` early.

        In gusts, corners are as near to each other as waypoints may be, and else twice as far. PX4
        flies to a corner and turns there: at the wider corners it banks in gusts by 50 degrees to
        both sides, and sinks, and at the near ones by 15 to one side.
        """
        z = self.start[2]
        asked_m = self.length_m - lead_m
        turn = abs(self.turn_rad)
        # The corner of a smaller turn would be too near to the start, where the leg begins anyway.
        if turn >= 2 * math.atan(self.apart_m / self.radius_m):
            reach_m = 0.5 * self.apart_m if is_gusty else self.apart_m
            widest = math.ceil(turn / _WIDEST_RAD)
            count = max(widest, int(turn / (2 * math.atan(reach_m / self.radius_m))))
            half = 0.5 * turn / count
            along = self.arc_m * (np.arange(count) + 0.5) / count
            if is_gusty and half <= _SMALL_RAD:
                along = along[1:]
            x, y, *_ = self.at(along, 1 / math.cos(half))
            # ArduPlane flies outside the arc if it looks at the next leg only at the arc.
            acceptance = math.floor(max(self.radius_m * math.tan(half), self.apart_m))
            for east, north, share in zip(x.tolist(), y.tolist(), along / asked_m, strict=True):
                yield RoutePoint(east, north, z + float(share) * (end_m - z), acceptance)
        x, y, *_ = self.at(np.array([asked_m]))
        yield RoutePoint(float(x[0]), float(y[0]), end_m, _ON_WAY_M)


def flown(
    problem: Problem, way: Way, lead_m: float, end_m: float, step_m: float = STEP_M
) -> tuple[tuple[Floats, Floats], Floats]:
    """Return points along and beside a way, and the heights of a late aircraft there."""
    z = way.start[2]
    corridor_m = CORNER_M + (0.0 if problem.rules is None else problem.rules.corridor_m)
    count = min(math.ceil(way.length_m / step_m) + 1, _MOST_POINTS)
    across = np.linspace(-corridor_m, corridor_m, 7)
    along, side = (
        grid.ravel() for grid in np.meshgrid(np.linspace(0, way.length_m, count), across)
    )
    x, y, east, north = way.at(along)
    climbed = np.maximum(along - lead_m, 0.0) / (way.length_m - lead_m)
    return (x - side * north, y + side * east), z + climbed * (end_m - z)


def ways_to(
    start: tuple[float, float, float],
    heading: tuple[float, float],
    place: tuple[float, float],
    *,
    radius_m: float,
    short_m: float,
    apart_m: float,
) -> list[Way]:
    """Return the ways that turn to the left or right and then point at a place, shortest first.

    Parameters
    ----------
    short_m : float
        Distance before the place at which the ways end.
    """
    made = []
    east, north = heading
    for side in (1, -1):
        dx = place[0] - start[0] + side * radius_m * north
        dy = place[1] - start[1] - side * radius_m * east
        square = dx**2 + dy**2 - radius_m**2
        if square <= short_m**2:
            continue
        straight_m = math.sqrt(square)
        course = math.atan2(dy, dx) + side * math.atan2(radius_m, straight_m)
        turn = side * (course - math.atan2(north, east)) % (2 * math.pi)
        turn = 0.0 if turn > 2 * math.pi - 1e-6 else turn
        made.append(Way(start, heading, radius_m, side * turn, straight_m - short_m, apart_m))
    return sorted(made, key=lambda way: way.length_m)
