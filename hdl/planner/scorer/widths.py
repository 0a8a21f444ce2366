"""Widths of the numbers of a score, from the maximum values that they take.

A score of the model is exact; so is the gateware's, with the fewest bits that hold every value. If
an arc does not fit, its numbers are undefined and may lose bits.
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
        """Maximum arcs of a path: with an entry and an exit, start and goal have one, too."""
        return self.waypoints + 2

    @property
    def segments(self) -> int:
        """Maximum segments of a path, segments from the entry and to the exit included."""
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
        """Width of a difference of positions, with its sign; a side has a scale of at most 1."""
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
        """Width of the product of two segments, as vectors, without a sign."""
        return (2 * ((1 << self.position) - 1) ** 2).bit_length()

    @property
    def tangent(self) -> int:
        """Width of a tangent length; the highest bit stands for all that do not fit any segment."""
        return self.length + 1

    @property
    def half_turn(self) -> int:
        """Width of the tangent of half a turn, 16 itself included: it is rounded up."""
        return SHARPEST_BITS + TURN_FRACTION + 1

    @property
    def share(self) -> int:
        """Width of a share of a segment, 1 included."""
        return SHARE_BITS + 1

    @property
    def arc(self) -> int:
        """Width of the length of an arc."""
        return RADIUS_BITS + TURN_BITS - TURN_FRACTION

    @property
    def run(self) -> int:
        """Width of the length of a piece: the rest that arcs leave of a segment, or an arc."""
        return max(self.length, self.arc)

    @cached_property
    def flown_square(self) -> int:
        """Maximum square of a length in three dimensions; an arc has at most its two tangents."""
        highest = 1 << self.part + RISE_BITS - RISE_FRACTION
        return (2 * self.longest) ** 2 + highest**2

    @property
    def flown(self) -> int:
        """Width of a length in three dimensions."""
        return (isqrt(4 * self.flown_square) + 1 >> 1).bit_length()

    @cached_property
    def level(self) -> int:
        """Width of the altitude above the datum, of both ends together, with its sign."""
        highest = (2 << self.part) + (1 << BASE_BITS - 1)
        return highest.bit_length() + 1

    @cached_property
    def pull(self) -> int:
        """Width of a pull, without a sign."""
        highest = (1 << DRAG_FRACTION + self.flown) + (1 << RISE_BITS + self.part)
        return highest.bit_length()

    @cached_property
    def piece(self) -> int:
        """Width of the cost of a piece, with its sign."""
        highest = (1 << self.level - 1 + self.flown) + (1 << self.pull + FUEL_BITS)
        return highest.bit_length() + 1

    @property
    def cost(self) -> int:
        """Width of the cost of a path, with its sign: a piece for every segment and every arc."""
        return self.piece + (self.segments + self.arcs).bit_length()

    @cached_property
    def total(self) -> int:
        """Width of the length of a path."""
        return (self.segments * self.longest).bit_length()

    @property
    def excess(self) -> int:
        """Width of the excess rise or fall of a segment, the maximum altitude included."""
        return self.part + EXCESS_BITS + 1

    @cached_property
    def steep(self) -> int:
        """Width of the count of the segments of a path that are too steep."""
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
