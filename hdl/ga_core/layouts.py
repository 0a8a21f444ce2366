"""Layouts that only the units of the paper core share."""

from amaranth.hdl import Shape
from amaranth.lib import data


__all__ = [
    "limits_layout",
    "mutation_layout",
    "offset_layout",
]


def limits_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of the highest x, y and altitude of a new waypoint.

    A waypoint has the same layout.
    """
    return data.StructLayout(
        {"x": coordinate_bits, "y": coordinate_bits, "altitude": altitude_bits}
    )


def offset_layout(box_cells: int, box_steps: int) -> data.StructLayout:
    """Return the layout of the signed distance of a new waypoint from its original.

    It is at most ``box_cells`` in x and y, and at most ``box_steps`` in altitude.
    """
    boxes = {"x": box_cells, "y": box_cells, "altitude": box_steps}
    return data.StructLayout(
        {axis: Shape.cast(range(-box, box + 1)) for axis, box in boxes.items()}
    )


def mutation_layout(children: int, max_waypoints: int) -> data.StructLayout:
    """Return the layout of one mutator's result: the child, and the index of its waypoint."""
    return data.StructLayout(
        {"applied": 1, "child": range(children), "index": range(max_waypoints)}
    )
