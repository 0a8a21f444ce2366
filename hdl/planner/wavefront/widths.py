"""Widths of the numbers of the wavefront."""

from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    BLOCKS,
    FAR,
    POSITION_FRACTION,
    VALUE_BITS,
)


__all__ = [
    "BLOCK_BITS",
    "CLIMB_SHIFT",
    "COST_BITS",
    "FACTOR_BITS",
    "INDEX_BITS",
    "PART_BITS",
    "distance_bits",
    "factor_fraction",
    "least_unit",
    "shift_limit",
]

#: Width of a coordinate of a block, and of its index, 32 y + x.
BLOCK_BITS = BLOCKS.bit_length() - 1
INDEX_BITS = 2 * BLOCK_BITS
#: Width of a cost, also of a block without a route to the goal.
COST_BITS = FAR.bit_length()
#: Width of a factor of altitudes: a multiplier cell takes no more.
FACTOR_BITS = 18
#: Fraction bits that a climb's factor has less than an altitude's: a climb costs less than 2**28.
CLIMB_SHIFT = 6
#: Width of a part of the cost of a step that does not depend on altitudes, its sign left out.
PART_BITS = VALUE_BITS


def shift_limit(coordinate_bits: int) -> int:
    """Return the maximum shift of a corner's coordinate to its block's."""
    return max(coordinate_bits - BLOCK_BITS, 0)


def distance_bits(coordinate_bits: int) -> int:
    """Return the width of a distance between the centres of two neighbouring blocks."""
    return shift_limit(coordinate_bits) + POSITION_FRACTION + 1


def factor_fraction(altitude_bits: int) -> int:
    """Return the fraction bits of an altitude's factor: all altitudes cost less than 2**23."""
    return max(altitude_bits - 4, 0)


def least_unit(coordinate_bits: int, altitude_bits: int) -> int:
    """Return the minimum binary logarithm of a cost's unit with which every factor fits."""
    width = distance_bits(coordinate_bits) + ALTITUDE_FRACTION + factor_fraction(altitude_bits)
    return max(width - FACTOR_BITS, 0)
