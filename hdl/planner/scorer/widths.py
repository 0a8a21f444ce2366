"""Widths of the numbers of a score, derived from their maximum values.

The model's score is exact, and so is the gateware's, with the minimum number of bits for every
value. If an arc does not fit, its numbers are undefined and may lose bits.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import isqrt

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    BASE_BITS,
    DRAG_FRACTION,
    EXCESS_BITS,
    FUEL_BITS,
    POSITION_FRACTION,
    RADIUS_BITS,
    RISE_BITS,
    RISE_FRACTION,
    SHARE_BITS,
    SHARPEST_BITS,
    STEEP,
    TURN_FRACTION,
)


__all__ = ["TURN_BITS", "Widths"]

#: Bits of a turn in radians, from :func:`pathgene.hdl.protocol.planner.turn_table`.
TURN_BITS = TURN_FRACTION + 2


@dataclass(frozen=True)
class Widths:
    """Widths of the numbers of one configuration.

    Parameters
    ----------
    coordinate, altitude : int
        Widths of a waypoint's coordinate and altitude.
    waypoints : int
        Maximum waypoints of a path.
    """

    coordinate: int
    altitude: int
    waypoints: int

    @classmethod
    def of(cls, config: Config) -> Widths:
        """Return the widths of ``config``."""
        return cls(config.coordinate_bits, config.altitude_bits, config.max_waypoints)

    @property
    def arcs(self) -> int:
        """Maximum arcs of a path: with an entry and an exit, start and goal also have one."""
        return self.waypoints + 2

    @property
    def segments(self) -> int:
        """Maximum segments of a path, including the segments from the entry and to the exit."""
        return self.arcs + 1

    @property
    def position(self) -> int:
        """Width of a position on the map."""
        return self.coordinate + POSITION_FRACTION

    @property
    def part(self) -> int:
        """Width of an altitude in parts."""
        return self.altitude + ALTITUDE_FRACTION

    @property
    def side(self) -> int:
        """Width of a signed difference of positions; the scale of a side is at most 1."""
        return self.position + 1

    @cached_property
    def longest(self) -> int:
        """Longest segment, from corner to corner of the map."""
        return isqrt(2 * ((1 << self.position) - 1) ** 2)

    @property
    def length(self) -> int:
        """Width of a segment's length."""
        return self.longest.bit_length()

    @cached_property
    def cross(self) -> int:
        """Width of the product of two segments as vectors, without sign."""
        return (2 * ((1 << self.position) - 1) ** 2).bit_length()

    @property
    def tangent(self) -> int:
        """Width of a tangent length; the highest bit marks lengths that fit no segment."""
        return self.length + 1

    @property
    def half_turn(self) -> int:
        """Width of the tangent of half a turn, including 16 itself, because it is rounded up."""
        return SHARPEST_BITS + TURN_FRACTION + 1

    @property
    def share(self) -> int:
        """Width of a share of a segment, including 1."""
        return SHARE_BITS + 1

    @property
    def arc(self) -> int:
        """Width of the length of an arc."""
        return RADIUS_BITS + TURN_BITS - TURN_FRACTION

    @property
    def run(self) -> int:
        """Width of the length of a piece: an arc, or the part of a segment that arcs leave."""
        return max(self.length, self.arc)

    @cached_property
    def flown_square(self) -> int:
        """Maximum square of a length in space; an arc is at most as long as its two tangents."""
        highest = 1 << self.part + RISE_BITS - RISE_FRACTION
        return (2 * self.longest) ** 2 + highest**2

    @property
    def flown(self) -> int:
        """Width of a length in three dimensions."""
        return (isqrt(4 * self.flown_square) + 1 >> 1).bit_length()

    @cached_property
    def level(self) -> int:
        """Width of the signed sum of the altitudes of both ends above the datum."""
        highest = (2 << self.part) + (1 << BASE_BITS - 1)
        return highest.bit_length() + 1

    @cached_property
    def pull(self) -> int:
        """Width of a pull, without sign."""
        highest = (1 << DRAG_FRACTION + self.flown) + (1 << RISE_BITS + self.part)
        return highest.bit_length()

    @cached_property
    def piece(self) -> int:
        """Width of the signed cost of a piece."""
        highest = (1 << self.level - 1 + self.flown) + (1 << self.pull + FUEL_BITS)
        return highest.bit_length() + 1

    @property
    def cost(self) -> int:
        """Width of the signed cost of a path: a piece for every segment and every arc."""
        return self.piece + (self.segments + self.arcs).bit_length()

    @cached_property
    def total(self) -> int:
        """Width of the length of a path."""
        return (self.segments * self.longest).bit_length()

    @property
    def excess(self) -> int:
        """Width of the excess rise or fall of a segment, up to the maximum altitude."""
        return self.part + EXCESS_BITS + 1

    @cached_property
    def steep(self) -> int:
        """Width of the number of steep segments of a path."""
        most = STEEP + (1 << self.part + EXCESS_BITS)
        return (self.segments * most).bit_length()

    @cached_property
    def steep_arcs(self) -> int:
        """Width of the length of all arcs of a path."""
        return (self.arcs * (1 << self.arc)).bit_length()

    @property
    def count(self) -> int:
        """Width of a number of arcs."""
        return self.arcs.bit_length()
