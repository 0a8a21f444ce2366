"""Payloads between the units of the wavefront."""

from amaranth import signed
from amaranth.lib import data

from hdl.planner.wavefront.widths import BLOCK_BITS, COST_BITS, distance_bits
from hdl.protocol.planner import BASE_BITS, DRAG_FRACTION, FUEL_BITS, RISE_BITS


__all__ = [
    "block_layout",
    "found_layout",
    "place_layout",
    "step_constants_layout",
    "way_layout",
]

#: x and y of a block.
place_layout = data.StructLayout({"x": BLOCK_BITS, "y": BLOCK_BITS})


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


def way_layout(coordinate_bits: int) -> data.StructLayout:
    """Return the layout of what depends on the direction of a step.

    ``distance`` : length of the step. ``pull`` : distance times drag times fuel. ``level`` :
    distance times base. ``fall`` : of the surface, at most 2**30.
    """
    distance = distance_bits(coordinate_bits)
    return data.StructLayout(
        {
            "distance": distance,
            "pull": distance + DRAG_FRACTION + FUEL_BITS,
            "level": signed(distance + BASE_BITS),
            "fall": COST_BITS,
        }
    )


def step_constants_layout(coordinate_bits: int) -> data.StructLayout:
    """Return the layout of the constants of all steps.

    ``ways`` : in x, in y, and across. ``climb`` : rise times fuel.
    """
    return data.StructLayout(
        {
            "ways": data.ArrayLayout(way_layout(coordinate_bits), 3),
            "climb": RISE_BITS + FUEL_BITS,
        }
    )
