"""Payloads between the units of the planner core."""

from amaranth.hdl import signed
from amaranth.lib import data
from amaranth.utils import exact_log2

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import (
    BASE_BITS,
    BEND_BITS,
    EDGE_BITS,
    EDGES,
    VALUE_BITS,
    problem_request,
)


__all__ = [
    "KEY_BITS",
    "corner_layout",
    "frame_layout",
    "head_layout",
    "member_layout",
    "path_layout",
    "problem_layout",
    "row_layout",
    "shape_layout",
    "slot_count",
    "waypoint_layout",
]


#: Width of a key: two bits of class above the value.
KEY_BITS = VALUE_BITS + 2
#: Maximum number of seeds that have a slot but no key.
_SEEDS = 18


def slot_count(config: Config, islands: int) -> int:
    """Return the number of slots of a chip.

    There is room for a population for each island and the children of two generations, or for the
    seeds in flight in the evaluator, if these are more.
    """
    return islands * config.population + max(2 * config.children, _SEEDS)


def corner_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a corner of the map and an altitude in steps."""
    return data.StructLayout(
        {"x": coordinate_bits, "y": coordinate_bits, "altitude": altitude_bits}
    )


def frame_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of the frame of all paths of a problem: three corners.

    ``limits``: maximum corner and altitude of a waypoint. ``start`` and ``goal``: ends of all
    paths.
    """
    corner = corner_layout(coordinate_bits, altitude_bits)
    return data.StructLayout({"limits": corner, "start": corner, "goal": corner})


def waypoint_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of a waypoint in the population.

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
    """Return the layout of a path: its slot, and its number of waypoints without start and goal."""
    return data.StructLayout({"slot": slot_bits, "length": length_bits})


def head_layout(slot_bits: int) -> data.StructLayout:
    """Return the layout of the head of a path, which precedes its points.

    ``first``: the best path of the population that it was bred from is feasible. ``limited``: the
    path at the give-up rank is feasible too, and with ``first``, this path is given up unless its
    value is below ``limit``, the value of that path.
    """
    return data.StructLayout({"slot": slot_bits, "first": 1, "limited": 1, "limit": VALUE_BITS})


def member_layout(slot_bits: int, length_bits: int) -> data.StructLayout:
    """Return the layout of a member of a population: its key, slot and length."""
    return data.StructLayout({"key": KEY_BITS, "slot": slot_bits, "length": length_bits})


def problem_layout(config: Config) -> data.StructLayout:
    """Return the layout of a problem's record: as in the request, but with a signed ``base``."""
    fields = dict(problem_request(config).fields)
    assert fields["base"] == BASE_BITS
    return data.StructLayout({**fields, "base": signed(BASE_BITS)})


def row_layout(lanes: int, coordinate_bits: int) -> data.StructLayout:
    """Return the layout of a row of ``lanes`` corners.

    ``x``: coordinate of the first corner, divided by ``lanes``, which is a power of two. ``y``.
    """
    return data.StructLayout({"x": coordinate_bits - exact_log2(lanes), "y": coordinate_bits})


def shape_layout(coordinate_bits: int) -> data.StructLayout:
    """Return the layout of corners to block: as in the request, but with signed edges.

    See :func:`pathgene.hdl.protocol.planner.no_fly_request`.
    """
    fields = dict.fromkeys(("first_x", "first_y", "last_x", "last_y"), coordinate_bits)
    fields |= {"bend_x": BEND_BITS, "bend_y": BEND_BITS}
    for edge in range(EDGES):
        fields |= {
            f"at_{edge}": signed(coordinate_bits + EDGE_BITS + 1),
            f"east_{edge}": signed(EDGE_BITS),
            f"north_{edge}": signed(EDGE_BITS),
        }
    return data.StructLayout(fields)
