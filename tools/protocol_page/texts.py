"""Texts of the protocol's page: a line for each command, code and field."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum

from pathgene.hdl.config import Config
from pathgene.hdl.protocol import (
    CheckFlag,
    ChipState,
    Command,
    Counter,
    Layout,
    LinkMode,
    Status,
    StickyError,
    check_paths_request,
    check_reply,
    check_request,
    counters_reply,
    entry_record,
    generate_request,
    hit_record,
    info_reply,
    map_request,
    path_record,
    read_request,
    recipe_reply,
    results_request,
    start_request,
    status_reply,
    survivors_reply,
    write_request,
)
from pathgene.hdl.protocol.planner import no_fly_request, problem_request
from pathgene.hdl.protocol.runs import run_request
from tools.protocol_page.segments import waypoint_layout


__all__ = ["CODES", "COMMANDS", "MESSAGES", "Field"]


@dataclass(frozen=True)
class Field:
    """Description of a field.

    Attributes
    ----------
    values : str
        Range of values.
    meaning : str
    width : str or None
        Attribute of :class:`pathgene.hdl.config.Config` that is its width; None if its width is
        constant.
    """

    values: str
    meaning: str
    width: str | None = None


#: Purpose of each command, payload of its request, payload of its reply.
COMMANDS = {
    Command.INFO: ("ask what the chip is", "none", "configuration"),
    Command.OPEN: ("open a session", "none", "none"),
    Command.STATUS: ("state, generation, sticky errors", "none", "fields"),
    Command.START: ("seed the random source", "fields", "none"),
    Command.WRITE: ("paths into slots", "slot, paths", "none"),
    Command.GENERATE: ("one generation", "link mode, ranking", "by link mode"),
    Command.READ: ("paths of slots", "slot, count", "paths"),
    Command.COUNTERS: ("cycles and bytes since reset", "none", "counters"),
    Command.CLEAR: ("clear the sticky errors", "none", "none"),
    Command.MAP: ("write a rectangle of the map", "rectangle, cells", "none"),
    Command.CHECK: ("check one path", "flags, points", "totals, result"),
    Command.CHECK_PATHS: ("check the paths of slots", "fields", "totals, results"),
    Command.RESULTS: ("results of the latest check again", "path, count", "results"),
    Command.PROBLEM: ("a problem for the planner core", "fields", "none"),
    Command.RUN: ("begin a run", "fields", "none"),
    Command.STOP: ("end the run with its present generation", "none", "none"),
    Command.BEST: ("paths of the latest run", "none", "keys, paths"),
    Command.BLOCK: ("block the corners in a shape", "fields", "none"),
}

CODES: Mapping[type[Enum], Mapping[Enum, str]] = {
    Status: {
        Status.OK: "The command is executed. The reply's payload follows.",
        Status.DUPLICATE: "The command was executed earlier. Nothing is done or sent again.",
        Status.OUT_OF_ORDER: "A command is missing. The reply's sequence is the expected number.",
        Status.NO_SESSION: "Another session is open.",
        Status.UNKNOWN_COMMAND: "The chip has no such command.",
        Status.BAD_LENGTH: "The payload is too short or too long for the command.",
        Status.BAD_VALUE: "A field is outside its range.",
        Status.BUSY: "A run is in progress; the command must wait for its end.",
    },
    LinkMode: {
        LinkMode.POPULATION: "The slots are sorted, best first. Reply: the whole new population.",
        LinkMode.RANK: "The request ranks the slots. Reply: survivors' slots and the children.",
        LinkMode.RECIPE: "The request ranks the slots. Reply: the recipe of the generation.",
    },
    CheckFlag: {
        CheckFlag.COUNT: "Count the colliding cells of every segment; do not stop at the first.",
        CheckFlag.BRIEF: "Reply with the totals only.",
    },
    ChipState: {
        ChipState.LISTEN: "No command is at hand.",
        ChipState.RECEIVE: "A command is parsed.",
        ChipState.CROSSOVER: "Crossover.",
        ChipState.MUTATE: "Mutation.",
        ChipState.UPDATE: "The new population becomes the present one.",
        ChipState.TRANSMIT: "A reply is made and sent.",
        ChipState.CHECK: "The collision checker runs.",
    },
    StickyError: {
        StickyError.FRAMING: "A byte had no stop bit.",
        StickyError.OVERRUN: "A frame was dropped: the receive buffer was full.",
        StickyError.CRC: "A frame was dropped: its CRC was wrong.",
        StickyError.MALFORMED: "A frame was dropped: too short, or a zero inside a COBS block.",
        StickyError.REFUSED: "A command was refused: UNKNOWN_COMMAND, BAD_LENGTH, BAD_VALUE, BUSY.",
    },
}

_SLOT = "0 … population − 1"
_SEGMENT = Field(
    "0 … max_waypoints", "Segment, 0 the one from the path's first point", "segment_bits"
)

_COUNTERS = {
    Counter.CYCLES: "Cycles",
    Counter.RECEIVE: "Cycles in which a frame came in or a command was parsed",
    Counter.CROSSOVER: "Cycles of crossover",
    Counter.MUTATION: "Cycles of mutation",
    Counter.UPDATE: "Cycles of population updates",
    Counter.TRANSMIT: "Cycles in which a reply was made or sent",
    Counter.LONGEST: "Cycles of the longest generation since the latest START",
    Counter.GENERATIONS: "Generations, runs included",
    Counter.REFUSED_MUTATIONS: "Mutations that a limit on the path's length forbade",
    Counter.BYTES_RECEIVED: "Bytes received, delimiters and damaged frames included",
    Counter.BYTES_SENT: "Bytes sent before this reply",
    Counter.FEASIBILITY: "Cycles of the collision checker",
    Counter.CELLS: "Cells checked, of each path up to its first hit",
    Counter.READS: "Addresses that the checker gave to the map's memory",
    Counter.PATHS: "Paths checked",
    Counter.REDRAWN: "New waypoints drawn again because they lay in the ground",
    Counter.LEFT_OUT: "Mutations left out because every draw lay in the ground",
}


def _planner(config: Config) -> Config:
    """Return a chip with the planner core, whose sizes are those of ``config``."""
    return config.replace(core="planner", checker="parallel")


#: Layout of each message, with its fields by name; numbered fields by the name without number.
MESSAGES: Mapping[str, tuple[Callable[[Config], Layout], Mapping[str, Field]]] = {
    "waypoint": (
        waypoint_layout,
        {
            "x": Field("0 … map_size − 1", "Column of the map, from the west", "coordinate_bits"),
            "y": Field("0 … map_size − 1", "Row of the map, from the south", "coordinate_bits"),
            "altitude": Field("0 … blocked − 1", "Altitude step", "altitude_bits"),
            "last": Field("0, 1", "1 ends the path"),
        },
    ),
    "info_reply": (
        info_reply,
        {
            "version": Field("1 … 255", "Version of the protocol"),
            "build_id": Field("any", "Fingerprint of the configuration; a host may ignore it"),
            "session": Field("0 … 255", "The open session"),
            "population": Field("power of two, 4 … 256", "Slots"),
            "children": Field("even, 4 or more", "Paths bred in each generation"),
            "elites": Field("1 or more", "Best paths that are always kept"),
            "survivors": Field("1 or more", "Other paths that are kept, drawn at random"),
            "perturbs": Field("1 or more", "Mutators that move a waypoint"),
            "inserts": Field("1 or more", "Mutators that insert a waypoint"),
            "deletes": Field("1 or more", "Mutators that delete a waypoint"),
            "max_waypoints": Field("3 … 64", "Waypoints of the longest path; the shortest has 2"),
            "map_size": Field("power of two, 8 … 4096", "Cells along each edge of the map"),
            "coarse_factor": Field("power of two", "Cells along the edge of a coarse cell"),
            "altitude_bits": Field("4 … 16", "Width of an altitude"),
            "box_percent": Field("1 … 100", "Edge of the mutation box, percent of the map's edge"),
            "rank_survivors": Field("0, 1", "1: survivors are drawn by rank; 0: uniformly"),
            "clock_hz": Field("1 or more", "Clock of the chip, hertz"),
            "clocks_per_bit": Field("4 … 65535", "Cycles of a bit on the line"),
            "receive_buffer": Field("power of two, 256 … 32768", "Credit in bytes, see above"),
            "core": Field("0, 1, 2", "Genetic core: 0 none, 1 paper, 2 planner"),
            "checker": Field("see below", "Build of the collision checker"),
            "lanes": Field("1, 2, 4, 8, 16", "Cells checked in a cycle"),
            "memory_latency": Field("1, 2", "Cycles from an address of the map to its data"),
            "redraws": Field("0 … 7", "Further draws of a new waypoint that lies in the ground"),
        },
    ),
    "status_reply": (
        status_reply,
        {
            "state": Field("a state", "State of the chip: always TRANSMIT, since it replies"),
            "history": Field("8 states", "Latest eight states, 4 bits each, the latest lowest"),
            "errors": Field("sticky errors", "Errors since reset or CLEAR"),
            "generation": Field("modulo 2³²", "Generations since START"),
            "crossover": Field("cycles", "Crossover of the latest generation"),
            "mutation": Field("cycles", "Mutation of the latest generation"),
            "update": Field("cycles", "Population update of the latest generation"),
        },
    ),
    "planner_status_reply": (
        lambda config: status_reply(_planner(config)),
        {
            "state": Field("a state", "State of the chip: always TRANSMIT, since it replies"),
            "history": Field("8 states", "Latest eight states, 4 bits each, the latest lowest"),
            "errors": Field("sticky errors", "Errors since reset or CLEAR"),
            "generation": Field("modulo 2³²", "Generations of the latest run, of all islands"),
            "running": Field("0, 1", "1: the run is not over"),
            "cycles": Field("modulo 2³²", "Cycles of the latest run"),
            "key": Field("a key", "Key of the best path, class 3 if there is none"),
            "breed": Field("modulo 2³²", "Cycles in which children were planned"),
            "score": Field("modulo 2³²", "Cycles in which points were scored"),
            "walk": Field("modulo 2³²", "Cycles in which segments and chords were walked"),
            "sort": Field("modulo 2³²", "Cycles in which a population was collected and sorted"),
            "wavefront": Field("modulo 2³²", "Cycles of scans, wavefronts and routes"),
        },
    ),
    "problem_request": (
        problem_request,
        {
            "start_x": Field("any", "Start, 1/256 of a cell from the first corner"),
            "start_y": Field("any", "The same northwards"),
            "start_altitude": Field("any", "Start, 1/16 of a step"),
            "goal_x": Field("any", "Goal"),
            "goal_y": Field("any", "The same northwards"),
            "goal_altitude": Field("any", "Goal, 1/16 of a step"),
            "x_limit": Field("0 … map_size − 1", "Highest x of a waypoint", "coordinate_bits"),
            "y_limit": Field("0 … map_size − 1", "Highest y of a waypoint", "coordinate_bits"),
            "altitude_limit": Field(
                "0 … blocked − 1", "Highest altitude of a waypoint", "altitude_bits"
            ),
            "x_scale": Field("0 … 2¹⁴", "Side of a cell in x, 2⁻¹⁴ of the longer side"),
            "y_scale": Field("0 … 2¹⁴", "Side of a cell in y"),
            "rise": Field("any", "1/16 of a step in units of length, 2⁻¹⁶"),
            "climb": Field("any", "Steepest climb, 1/16 of a step per unit of length, 2⁻¹²"),
            "descent": Field("any", "Steepest descent"),
            "radius": Field("any", "Turning radius, units of length"),
            "base": Field("two's complement", "Altitude of step 0, 1/32 of a step"),
            "drag": Field("any", "Drag of level flight, 2⁻¹⁶ of the weight"),
            "fuel": Field("any", "Weight of fuel in the cost"),
            "fuel_shift": Field("any", "Right shift of that weight"),
            "key_shift": Field("any", "Right shift of a cost that makes it a value"),
            "block_shift": Field(
                "0 … ⌈log₂ map_size⌉ − 5, or 0",
                "Corners of a block, as a power of two",
            ),
            "has_entry": Field("0, 1", "1: the heading at the start is fixed by a point before it"),
            "entry_x": Field("any", "That point, which counts in the score alone"),
            "entry_y": Field("any", "The same northwards"),
            "entry_altitude": Field("any", "1/16 of a step"),
            "has_exit": Field("0, 1", "1: the heading at the goal is fixed by a point beyond it"),
            "exit_x": Field("any", "That point"),
            "exit_y": Field("any", "The same northwards"),
            "exit_altitude": Field("any", "1/16 of a step"),
        },
    ),
    "run_request": (
        run_request,
        {
            "seed": Field("any", "Seed of the random source"),
            "cycles": Field("any", "The run ends with the generation that reaches them"),
            "generations": Field("any", "Or these, of all islands together"),
            "give_up_rank": Field(_SLOT, "A child not cheaper than this rank is not walked"),
            "seeds": Field("population or more", "Paths seeded along each route"),
            "lifts": Field("0 … 4", "Passes that raise a first population out of the ground"),
            "share": Field("0 … 16", "Sixteenths of the time that two islands have together"),
            "warm": Field("0, 1", "1: the population of the run before is the first island"),
            "islands": Field("1, 2; 0, 1 if warm", "Islands of fresh seeds"),
            "until_feasible": Field("0, 1", "1: the generations wait for a feasible path"),
            "slope": Field("0 … 15", "Steepest slope of each, in halves of the climb limit; 0 any"),
            "paths": Field("1 … 8", "Maximum number of paths that BEST returns"),
        },
    ),
    "no_fly_request": (
        no_fly_request,
        {
            "first_x": Field("0 … last_x", "First corner of the box", "coordinate_bits"),
            "first_y": Field("0 … last_y", "The same northwards", "coordinate_bits"),
            "last_x": Field("0 … map_size − 1", "Last corner of the box", "coordinate_bits"),
            "last_y": Field("0 … map_size − 1", "The same northwards", "coordinate_bits"),
            "bend_x": Field("any", "Bend of edge 0 eastwards"),
            "bend_y": Field("any", "The same northwards"),
            "at": Field("two's complement", "Value of an edge at the first corner"),
            "east": Field("two's complement", "Its gain per corner eastwards"),
            "north": Field("two's complement", "The same northwards"),
        },
    ),
    "start_request": (
        start_request,
        {
            "seed": Field("any", "Seed of the random source"),
            "x": Field("0 … map_size − 1", "Highest x of a new waypoint"),
            "y": Field("0 … map_size − 1", "Highest y of a new waypoint"),
            "altitude": Field("0 … blocked − 1", "Highest altitude of a new waypoint"),
            "avoid_ground": Field("0; 1 with a checker", "Draw a waypoint in the ground again"),
        },
    ),
    "write_request": (write_request, {"slot": Field(_SLOT, "First slot")}),
    "read_request": (
        read_request,
        {
            "slot": Field(_SLOT, "First slot"),
            "count": Field("1 … population − slot", "Slots"),
        },
    ),
    "generate_request": (
        lambda config: generate_request(config, LinkMode.RANK),
        {
            "mode": Field("link mode", "Form of request and reply"),
            "slot": Field(_SLOT, "Slots from the best path to the worst: each exactly once"),
        },
    ),
    "survivors_reply": (
        survivors_reply,
        {"survivor": Field(_SLOT, "Slot of a survivor before this generation")},
    ),
    "recipe_reply": (
        recipe_reply,
        {
            "parent": Field(_SLOT, "Slot of a parent before this generation", "slot_bits"),
            "survivor": Field(_SLOT, "Slot of a survivor before this generation", "slot_bits"),
            "applied": Field("0, 1", "1: the mutation was applied"),
            "child": Field("0 … children − 1", "Child of the mutator", "child_bits"),
            "index": Field("0 … max_waypoints − 1", "Waypoint of that child", "index_bits"),
            "waypoint": Field("a waypoint", "New waypoint, without its last bit", "waypoint_bits"),
            "checksum": Field("CRC-32", "The new population as READ of all slots returns it"),
        },
    ),
    "counters_reply": (
        counters_reply,
        {counter.value: Field("modulo 2⁴⁸", text) for counter, text in _COUNTERS.items()},
    ),
    "map_request": (
        map_request,
        {
            "x": Field("0 … map_size − 1", "Westernmost column"),
            "y": Field("0 … map_size − 1", "Southernmost row"),
            "width": Field("1 … map_size − x", "Columns"),
            "height": Field("1 … map_size − y", "Rows"),
        },
    ),
    "check_request": (check_request, {"flags": Field("0 … 3", "Check flags")}),
    "check_paths_request": (
        check_paths_request,
        {
            "slot": Field(_SLOT, "First slot"),
            "count": Field("1 … population − slot", "Slots"),
            "flags": Field("0 … 3", "Check flags"),
            "start": Field("a waypoint", "First point of every path", "waypoint_bits"),
            "goal": Field("a waypoint", "Last point of every path", "waypoint_bits"),
        },
    ),
    "results_request": (
        results_request,
        {
            "path": Field("0 … paths − 1", "First path of the latest check"),
            "count": Field("1 … paths − path", "Paths"),
        },
    ),
    "check_reply": (
        check_reply,
        {
            "cycles": Field("modulo 2³²", "Cycles of the checker"),
            "reads": Field("modulo 2³²", "Addresses given to the map's memory"),
            "cells": Field("modulo 2³²", "Cells checked, of each path up to its first hit"),
        },
    ),
    "path_record": (
        path_record,
        {
            "collision": Field("0, 1", "1: the path collides, and a hit record follows"),
            "entries": Field("0 … 127", "Entry records that follow; 0 unless counting"),
        },
    ),
    "hit_record": (
        hit_record,
        {
            "segment": _SEGMENT,
            "coarse": Field("0, 1", "1: x and y are a cell of the coarse map"),
            "x": Field("0 … map_size − 1", "Column of the first hit", "coordinate_bits"),
            "y": Field("0 … map_size − 1", "Row of the first hit", "coordinate_bits"),
            "cells": Field("1 or more", "Cells checked up to this one", "path_cells_bits"),
        },
    ),
    "entry_record": (
        entry_record,
        {
            "segment": _SEGMENT,
            "terrain": Field("0 … map_size", "Its cells in terrain", "segment_cells_bits"),
            "nofly": Field("0 … map_size", "Its blocked cells", "segment_cells_bits"),
        },
    ),
}
