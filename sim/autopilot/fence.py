"""Fences of an autopilot: polygons and circles to stay in or out of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from pathgene.sim.autopilot.items import Command, Item
from pathgene.sim.autopilot.places import Plane, Vector, distance


__all__ = ["Fence", "storage_bytes"]

_POLYGONS = (Command.FENCE_POLYGON_IN, Command.FENCE_POLYGON_OUT)
_CIRCLES = (Command.FENCE_CIRCLE_IN, Command.FENCE_CIRCLE_OUT)


@dataclass(frozen=True)
class Fence:
    """Areas of a fence, on the plane around home.

    Parameters
    ----------
    polygons : tuple of (corners, bool)
        Corners, and whether the aircraft must stay inside.
    circles : tuple of (centre, radius, bool)
        Likewise.
    """

    polygons: tuple[tuple[tuple[Vector, ...], bool], ...] = ()
    circles: tuple[tuple[Vector, float, bool], ...] = ()

    @classmethod
    def of(cls, items: Sequence[Item], plane: Plane) -> Fence:
        """Return the fence of a list of items that has no fault."""
        polygons, circles = [], []
        number = 0
        while number < len(items):
            item = items[number]
            if item.command in _POLYGONS:
                corners = items[number : number + int(item.params[0])]
                places = tuple(plane.local(corner.lat, corner.lon) for corner in corners)
                polygons.append((places, item.command == Command.FENCE_POLYGON_IN))
                number += len(corners)
                continue
            if item.command in _CIRCLES:
                centre = plane.local(item.lat, item.lon)
                circles.append((centre, item.params[0], item.command == Command.FENCE_CIRCLE_IN))
            number += 1
        return cls(tuple(polygons), tuple(circles))

    @staticmethod
    def fault(items: Sequence[Item]) -> str | None:
        """Return why a list of items is no fence, in the autopilot's words, or None."""
        number = 0
        returns = 0
        while number < len(items):
            item = items[number]
            count = 1
            if item.command in _POLYGONS:
                count = int(item.params[0])
                if count < 3:
                    return f"Invalid vertex count ({count})"
                corners = items[number : number + count]
                if any(corner.command != item.command for corner in corners):
                    return "Received incorrect vertex type"
                if any(int(corner.params[0]) != count for corner in corners):
                    return "Unexpected vertex count"
                if len(corners) < count:
                    return "Incorrect item count"
            elif item.command in _CIRCLES:
                if not item.params[0] > 0:
                    return "Non-positive circle radius"
            else:
                returns += 1
                if returns > 1:
                    return "Multiple return points"
            number += count
        return None

    def breached(self, place: Vector) -> bool:
        """Return whether a place is outside the fence."""
        return any(
            _inside(place, corners) != stays_in for corners, stays_in in self.polygons
        ) or any(
            (distance(place, centre) <= radius) != stays_in
            for centre, radius, stays_in in self.circles
        )


def storage_bytes(items: Sequence[Item]) -> int:
    """Return the bytes of ArduPilot's storage that a fence takes.

    Four for the header; for each polygon two and eight a corner, thirteen for a circle, nine for a
    return point.
    """
    total = 4
    number = 0
    while number < len(items):
        item = items[number]
        if item.command in _POLYGONS:
            corners = max(int(item.params[0]), 1)
            total += 2 + 8 * corners
            number += corners
        else:
            total += 13 if item.command in _CIRCLES else 9
            number += 1
    return total


def _inside(place: Vector, corners: tuple[Vector, ...]) -> bool:
    """Return whether a place is inside a polygon, by the even-odd rule."""
    x, y = place
    inside = False
    for (xa, ya), (xb, yb) in pairwise((*corners, corners[0])):
        if (ya > y) != (yb > y) and x < (xb - xa) * (y - ya) / (yb - ya) + xa:
            inside = not inside
    return inside
