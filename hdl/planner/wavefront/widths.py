"""Widths of the numbers of the wavefront."""

from hdl.protocol.planner import BLOCKS, POSITION_FRACTION


__all__ = ["BLOCK_BITS", "COST_BITS", "FAR", "INDEX_BITS", "distance_bits", "shift_limit"]

#: Width of a coordinate of a block, and of its index, 32 y + x.
BLOCK_BITS = BLOCKS.bit_length() - 1
INDEX_BITS = 2 * BLOCK_BITS
#: Cost of a block without a way to the goal, and the greatest cost of a step.
FAR = 1 << 30
#: Width of a cost up to :data:`FAR`.
COST_BITS = 31


def shift_limit(coordinate_bits: int) -> int:
    """Return the greatest shift of a corner's coordinate to its block's."""
    return max(coordinate_bits - BLOCK_BITS, 0)


def distance_bits(coordinate_bits: int) -> int:
    """Return the width of a distance between the centres of two neighbouring blocks."""
    return shift_limit(coordinate_bits) + POSITION_FRACTION + 1
