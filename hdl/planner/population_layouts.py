"""Layouts of what a population consists of, and of the numbers that find it."""

from amaranth import signed
from amaranth.lib import data

from hdl.config import Config
from hdl.protocol.planner import VALUE_BITS


__all__ = [
    "KEY_BITS",
    "child_layout",
    "corner_layout",
    "member_layout",
    "slot_count",
    "waypoint_layout",
]

#: Width of a key: two bits of class above the value.
KEY_BITS = VALUE_BITS + 2


def slot_count(config: Config, islands: int) -> int:
    """Return the slots of a chip: a population for each island, and the children of one."""
    return islands * config.population + config.children


def corner_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a corner of the map and an altitude in steps."""
    return data.StructLayout(
        {"x": coordinate_bits, "y": coordinate_bits, "altitude": altitude_bits}
    )


def waypoint_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a waypoint as the population holds it.

    ``margin`` is the least altitude above ground of the segments at the waypoint.
    """
    return data.StructLayout(
        {
            "x": coordinate_bits,
            "y": coordinate_bits,
            "altitude": altitude_bits,
            "margin": signed(altitude_bits + 1),
        }
    )


def child_layout(slot_bits: int, length_bits: int) -> data.StructLayout:
    """Return the layout of a child: its slot, and its waypoints without start and goal."""
    return data.StructLayout({"slot": slot_bits, "length": length_bits})


def member_layout(slot_bits: int, length_bits: int) -> data.StructLayout:
    """Return the layout of a member of a population: its key, slot and length."""
    return data.StructLayout({"key": KEY_BITS, "slot": slot_bits, "length": length_bits})
