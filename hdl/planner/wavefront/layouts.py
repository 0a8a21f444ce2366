"""Widths and payloads of the wavefront."""

from amaranth import Cat, Const, Mux, signed
from amaranth.lib import data

from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    BLOCKS,
    COARSE_BLOCKS,
    FAR,
    POSITION_FRACTION,
    VALUE_BITS,
)


__all__ = [
    "BLOCK_BITS",
    "CLIMB_SHIFT",
    "COARSE_BITS",
    "COST_BITS",
    "FACTOR_BITS",
    "INDEX_BITS",
    "PART_BITS",
    "block_layout",
    "by_rows",
    "distance_bits",
    "factor_fraction",
    "found_layout",
    "least_unit",
    "place_layout",
    "shift_limit",
    "step_constants_layout",
    "way_layout",
]


#: Width of a coordinate of a block, and of its index, 64 y + x.
BLOCK_BITS = BLOCKS.bit_length() - 1
INDEX_BITS = 2 * BLOCK_BITS
#: The same on a map of 32 x 32 blocks.
COARSE_BITS = COARSE_BLOCKS.bit_length() - 1
#: Width of a cost, including the cost of a block without a route to the goal.
COST_BITS = FAR.bit_length()
#: Width of a factor of altitudes, the maximum of a multiplier cell.
FACTOR_BITS = 18
#: A climb's factor has this many fraction bits fewer than an altitude's: a climb costs less than
#: 2**28.
CLIMB_SHIFT = 6
#: Width of a part of a step's cost that does not depend on altitudes, without its sign.
PART_BITS = VALUE_BITS


def shift_limit(coordinate_bits: int) -> int:
    """Return the maximum shift from a corner's coordinate to its block's."""
    return max(coordinate_bits - COARSE_BITS, 0)


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


def by_rows(number, fine):
    """Return x and y of a block, given its number when blocks are counted by rows.

    With ``fine`` a row has 64 blocks, otherwise 32. Higher bits of ``number`` do not count.
    """
    coarse = [number[i * COARSE_BITS : (i + 1) * COARSE_BITS] for i in range(2)]
    whole = [number[i * BLOCK_BITS : (i + 1) * BLOCK_BITS] for i in range(2)]
    x, y = (
        Mux(fine, one, Cat(other, Const(0, 1))) for one, other in zip(whole, coarse, strict=True)
    )
    return x, y


#: Position of a block.
place_layout = data.StructLayout({"x": BLOCK_BITS, "y": BLOCK_BITS})

#: Constants of a step that depend on its direction: ``factor``, of the sum of both altitudes;
#: ``level``, cost of the base; ``pull``, cost of fuel in level flight. See
#: :class:`pathgene.sim.model.planner.definition.wavefront.Prices`.
way_layout = data.StructLayout(
    {"factor": FACTOR_BITS, "level": signed(PART_BITS + 1), "pull": PART_BITS}
)

#: Constants of all steps: ``ways`` in x, in y, and across; ``climb``, factor of the rise.
step_constants_layout = data.StructLayout(
    {"ways": data.ArrayLayout(way_layout, 3), "climb": FACTOR_BITS}
)


def block_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a block of the map.

    ``free``; ``altitude``: of a free block, the surface before slopes are limited. ``x``, ``y``:
    first of the lowest corners.
    """
    return data.StructLayout(
        {"free": 1, "altitude": altitude_bits, "x": coordinate_bits, "y": coordinate_bits}
    )


def found_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a waypoint, which is ``valid`` in the cycle in which it is found.

    ``last`` ends its path.
    """
    return data.StructLayout(
        {
            "valid": 1,
            "last": 1,
            "x": coordinate_bits,
            "y": coordinate_bits,
            "altitude": altitude_bits,
        }
    )
