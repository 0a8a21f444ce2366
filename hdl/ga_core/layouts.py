"""Payloads of the streams between the receiving unit, the core and the transmitting unit.

And what the core's own units tell each other.
"""

from amaranth.hdl import Shape
from amaranth.lib import data

from hdl.config import Config
from hdl.protocol import start_request


__all__ = [
    "limits_layout",
    "mutation_layout",
    "offset_layout",
    "ranking_layout",
    "read_layout",
    "start_layout",
    "waypoint_layout",
    "write_layout",
]


def start_layout(config: Config) -> data.StructLayout:
    """Seed, highest values of new waypoints, and whether those in the ground are refused."""
    return data.StructLayout(dict(start_request(config).fields))


def write_layout(config: Config) -> data.StructLayout:
    """One waypoint of a path and where it goes; ``last`` ends the path."""
    return data.StructLayout(
        {
            "slot": config.slot_bits,
            "index": config.index_bits,
            "waypoint": config.waypoint_bits,
            "last": 1,
        }
    )


def ranking_layout(config: Config) -> data.StructLayout:
    """Slot of one rank."""
    return data.StructLayout({"rank": config.slot_bits, "slot": config.slot_bits})


def read_layout(config: Config) -> data.StructLayout:
    """Consecutive slots: the first, and how many."""
    return data.StructLayout({"slot": config.slot_bits, "count": config.slot_bits + 1})


def waypoint_layout(config: Config) -> data.StructLayout:
    """One waypoint read out; ``last`` ends its path, ``final`` the last path."""
    return data.StructLayout({"waypoint": config.waypoint_bits, "last": 1, "final": 1})


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
