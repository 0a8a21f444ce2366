"""Payloads of the streams between the folders of the gateware.

Command units, genetic core and checker agree here, so that none of them imports another.
"""

from amaranth.lib import data

from hdl.config import Config
from hdl.protocol import Layout, start_request


__all__ = [
    "cell_layout",
    "check_layout",
    "point_layout",
    "ranking_layout",
    "read_layout",
    "record_layout",
    "start_layout",
    "struct",
    "waypoint_layout",
    "write_layout",
]


def struct(layout: Layout) -> data.StructLayout:
    """Return the fields of a message as those of a signal."""
    return data.StructLayout(dict(layout.fields))


def start_layout(config: Config) -> data.StructLayout:
    """Return the layout of a run's seed, limits of new waypoints, and regard to the ground."""
    return struct(start_request(config))


def write_layout(config: Config) -> data.StructLayout:
    """Return the layout of one waypoint and its place; ``last`` ends the path."""
    return data.StructLayout(
        {
            "slot": config.slot_bits,
            "index": config.index_bits,
            "waypoint": config.waypoint_bits,
            "last": 1,
        }
    )


def ranking_layout(config: Config) -> data.StructLayout:
    """Return the layout of a rank and its slot."""
    return data.StructLayout({"rank": config.slot_bits, "slot": config.slot_bits})


def read_layout(config: Config) -> data.StructLayout:
    """Return the layout of consecutive slots to read: the first, and their count."""
    return data.StructLayout({"slot": config.slot_bits, "count": config.slot_bits + 1})


def waypoint_layout(config: Config) -> data.StructLayout:
    """Return the layout of one waypoint read; ``last`` ends its path, ``final`` the last path."""
    return data.StructLayout({"waypoint": config.waypoint_bits, "last": 1, "final": 1})


def check_layout(config: Config) -> data.StructLayout:
    """Return the layout of a command to check paths.

    ``counting``: the colliding cells are counted. ``batch``: the paths of ``count`` slots from
    ``slot`` are checked, each from ``start`` to ``goal``; otherwise the path whose points the
    command carries.
    """
    return data.StructLayout(
        {
            "counting": 1,
            "batch": 1,
            "slot": 8,
            "count": 8,
            "start": config.waypoint_bits,
            "goal": config.waypoint_bits,
        }
    )


def point_layout(config: Config) -> data.StructLayout:
    """Return the layout of one point, in cells and altitude steps; ``last`` marks the goal."""
    return data.StructLayout(
        {
            "x": config.coordinate_bits,
            "y": config.coordinate_bits,
            "altitude": config.altitude_bits,
            "last": 1,
        }
    )


def cell_layout(config: Config) -> data.StructLayout:
    """Return the layout of one cell to write; ``last`` ends a rectangle."""
    return point_layout(config)


def record_layout(config: Config) -> data.StructLayout:
    """Return the layout of one byte of the results; ``last`` ends the answer."""
    return data.StructLayout({"data": 8, "last": 1})
