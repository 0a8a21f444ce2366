"""Payloads between the units of the wavefront."""

from amaranth import signed
from amaranth.lib import data

from pathgene.hdl.planner.wavefront.widths import BLOCK_BITS, FACTOR_BITS, PART_BITS


__all__ = [
    "block_layout",
    "found_layout",
    "place_layout",
    "step_constants_layout",
    "way_layout",
]

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

    ``free``; ``altitude``: of a free block, the surface's before slopes are limited. ``x``, ``y``:
    first of the lowest corners.
    """
    return data.StructLayout(
        {"free": 1, "altitude": altitude_bits, "x": coordinate_bits, "y": coordinate_bits}
    )


def found_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a waypoint in the cycle in which it is found: ``valid``, with the rest.

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
