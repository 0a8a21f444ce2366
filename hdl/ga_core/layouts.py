"""Layouts that only the units of the genetic core share."""

from amaranth.hdl import Shape
from amaranth.lib import data

from hdl.config import Config


__all__ = [
    "limits_layout",
    "mutation_layout",
    "offset_layout",
]


def limits_layout(config: Config) -> data.StructLayout:
    """Highest x, y and altitude of a new waypoint."""
    return data.StructLayout(
        {
            "x": config.coordinate_bits,
            "y": config.coordinate_bits,
            "altitude": config.altitude_bits,
        }
    )


def offset_layout(config: Config) -> data.StructLayout:
    """Signed distance of a new waypoint from the one it is made of, within the mutation box."""
    boxes = {"x": config.box_cells, "y": config.box_cells, "altitude": config.box_steps}
    return data.StructLayout(
        {axis: Shape.cast(range(-box, box + 1)) for axis, box in boxes.items()}
    )


def mutation_layout(config: Config) -> data.StructLayout:
    """What one mutator did."""
    return data.StructLayout({"applied": 1, "child": config.child_bits, "index": config.index_bits})
