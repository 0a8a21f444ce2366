"""Layouts of the members of a population, their waypoints, and their keys."""

from amaranth import signed
from amaranth.lib import data

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import VALUE_BITS


__all__ = [
    "KEY_BITS",
    "corner_layout",
    "frame_layout",
    "head_layout",
    "member_layout",
    "path_layout",
    "slot_count",
    "waypoint_layout",
]

#: Width of a key: two bits of class above the value.
KEY_BITS = VALUE_BITS + 2
#: Maximum seeds with a slot and no key.
_SEEDS = 18


def slot_count(config: Config, islands: int) -> int:
    """Return the slots of a chip.

    A population for each island, and the children of two generations; or the seeds that are in
    flight in the evaluator, if these are more.
    """
    return islands * config.population + max(2 * config.children, _SEEDS)


def corner_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a corner of the map and an altitude in steps."""
    return data.StructLayout(
        {"x": coordinate_bits, "y": coordinate_bits, "altitude": altitude_bits}
    )


def frame_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of the frame of all paths of a problem, three corners.

    ``limits``: maximum corner and altitude of a waypoint. ``start`` and ``goal``: ends of all
    paths.
    """
    corner = corner_layout(coordinate_bits, altitude_bits)
    return data.StructLayout({"limits": corner, "start": corner, "goal": corner})


def waypoint_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a waypoint as the population holds it.

    ``margin`` is the minimum altitude above ground of the segments at the waypoint.
    """
    return data.StructLayout(
        {
            "x": coordinate_bits,
            "y": coordinate_bits,
            "altitude": altitude_bits,
            "margin": signed(altitude_bits + 1),
        }
    )


def path_layout(slot_bits: int, length_bits: int) -> data.StructLayout:
    """Return the layout of a path: its slot, and its waypoints without start and goal."""
    return data.StructLayout({"slot": slot_bits, "length": length_bits})


def head_layout(slot_bits: int) -> data.StructLayout:
    """Return the layout of the facts that come before the points of a path.

    ``first``: the best path of the population that it was bred from is feasible. ``limited``: so is
    the one at the give-up rank, and with ``first`` the path is given up unless its value is below
    ``limit``, the value there.
    """
    return data.StructLayout({"slot": slot_bits, "first": 1, "limited": 1, "limit": VALUE_BITS})


def member_layout(slot_bits: int, length_bits: int) -> data.StructLayout:
    """Return the layout of a member of a population: its key, slot and length."""
    return data.StructLayout({"key": KEY_BITS, "slot": slot_bits, "length": length_bits})
