"""Payloads of the streams between the folders of the gateware.

Command units, paper core and checker agree here, so that none of them imports another.
"""

from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.protocol.layout import Layout
from pathgene.hdl.protocol.messages import start_request


__all__ = [
    "cell_layout",
    "check_layout",
    "generation_signature",
    "point_layout",
    "ranking_layout",
    "read_layout",
    "record_layout",
    "result_read_layout",
    "start_layout",
    "struct",
    "waypoint_layout",
    "write_layout",
]


#: Consecutive paths of the latest check whose results are sent: the first path and the count.
result_read_layout = data.StructLayout({"path": 8, "count": 9})

#: One byte of the results; ``last`` ends the answer.
record_layout = data.StructLayout({"data": 8, "last": 1})


def struct(layout: Layout) -> data.StructLayout:
    """Return the layout of a signal with the fields of a message."""
    return data.StructLayout(dict(layout.fields))


def start_layout(config: Config) -> data.StructLayout:
    """Return the layout of a run: seed, waypoint limits, and whether waypoints avoid the ground."""
    return struct(start_request(config))


def write_layout(slot_bits: int, index_bits: int, waypoint_bits: int) -> data.StructLayout:
    """Return the layout of one waypoint and its place; ``last`` ends the path."""
    return data.StructLayout(
        {"slot": slot_bits, "index": index_bits, "waypoint": waypoint_bits, "last": 1}
    )


def ranking_layout(slot_bits: int) -> data.StructLayout:
    """Return the layout of a rank and its slot."""
    return data.StructLayout({"rank": slot_bits, "slot": slot_bits})


def read_layout(slot_bits: int) -> data.StructLayout:
    """Return the layout of consecutive slots to read: the first slot and the count."""
    return data.StructLayout({"slot": slot_bits, "count": slot_bits + 1})


def waypoint_layout(waypoint_bits: int) -> data.StructLayout:
    """Return the layout of one waypoint read; ``last`` ends its path, ``final`` the last path."""
    return data.StructLayout({"waypoint": waypoint_bits, "last": 1, "final": 1})


def check_layout(waypoint_bits: int) -> data.StructLayout:
    """Return the layout of a command to check paths.

    ``counting``: the colliding cells are counted. ``batch``: the paths of ``count`` slots from
    ``slot`` are checked, each from ``start`` to ``goal``; otherwise the path whose points are in
    the command.
    """
    return data.StructLayout(
        {
            "counting": 1,
            "batch": 1,
            "slot": 8,
            "count": 8,
            "start": waypoint_bits,
            "goal": waypoint_bits,
        }
    )


def point_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of one point, in cells and altitude steps; ``last`` marks the goal."""
    return data.StructLayout(
        {"x": coordinate_bits, "y": coordinate_bits, "altitude": altitude_bits, "last": 1}
    )


def cell_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of one cell to write; ``last`` ends a rectangle."""
    return point_layout(coordinate_bits, altitude_bits)


def generation_signature(config: Config) -> wiring.Signature:
    """Return the signature between control unit and paper core, from the control unit's side.

    launch : Out(1)
        Pulse in the cycle before ``begin``.
    begin : Out(1)
        Pulse in the cycle before the crossover's first.
    generating : Out(1)
        A generation runs, from ``begin`` to the last cycle of the update.
    mutation_on, update_on : Out(1)
        The unit is on.
    ready : In(1)
        A generation may start.
    restart : In(1)
        Pulse: a new run begins.
    crossover_done, mutation_done, update_done : In(1)
        Last cycle of the unit. Ignored unless the unit is on.
    refused : In(range(mutators + 1))
        Mutations that a length limit forbade. This and the next two count the current generation
        and are read in the last cycle of the update.
    redrawn : In(range(patches * candidates))
        Only with a map: candidates that replaced a candidate in the ground.
    left_out : In(range(patches + 1))
        Only with a map: mutations that had no candidate above the ground.
    """
    map_members = {
        "redrawn": In(range(config.patches * config.candidates)),
        "left_out": In(range(config.patches + 1)),
    }
    return wiring.Signature(
        {
            "launch": Out(1),
            "begin": Out(1),
            "generating": Out(1),
            "mutation_on": Out(1),
            "update_on": Out(1),
            "ready": In(1),
            "restart": In(1),
            "crossover_done": In(1),
            "mutation_done": In(1),
            "update_done": In(1),
            "refused": In(range(config.mutators + 1)),
            **(map_members if config.checker is not CheckerBuild.NONE else {}),
        }
    )
