"""Fixed fields of requests and replies, as functions of the configuration."""

from __future__ import annotations

import functools

from pathgene.hdl.config import CheckerBuild, Config, GeneticCore, SurvivorSelection
from pathgene.hdl.protocol.codec import VERSION
from pathgene.hdl.protocol.codes import COUNTER_BITS, UNITS, Counter, LinkMode
from pathgene.hdl.protocol.layout import Field, Layout, numbered, sized
from pathgene.hdl.protocol.random_words import SEED_BITS


__all__ = [
    "CODED_COLUMNS",
    "ESCAPE_ONES",
    "check_paths_request",
    "check_reply",
    "check_request",
    "coded_map_request",
    "config_from_info",
    "counters_reply",
    "entry_record",
    "generate_request",
    "hit_record",
    "info_reply",
    "info_values",
    "map_request",
    "path_record",
    "read_request",
    "recipe_reply",
    "results_request",
    "start_request",
    "status_reply",
    "survivors_reply",
    "write_request",
]

#: Checkers in the order of their numbers in :func:`info_reply`. Number 3 belonged to a build that
#: has been removed; it stays unused.
_CHECKERS = (CheckerBuild.NONE, CheckerBuild.TWO_TIER, CheckerBuild.PARALLEL)
#: Genetic cores in the order of their numbers in :func:`info_reply`.
_CORES = (GeneticCore.NONE, GeneticCore.PAPER, GeneticCore.PLANNER)


#: Maximum columns of a rectangle with coded cells.
CODED_COLUMNS = 64
#: Number of ones that precede the altitude of a cell whose error is not coded.
ESCAPE_ONES = 15

_SLOTS = "0 … population − 1"
#: Meanings of the cycles of a run, by unit.
_UNITS = {
    "breed": "Cycles in which children were planned",
    "score": "Cycles in which points were scored",
    "walk": "Cycles in which segments and chords were walked",
    "sort": "Cycles in which a population was collected and sorted",
    "wavefront": "Cycles of scans, wavefronts and routes",
}
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


def start_request(config: Config) -> Layout:
    """Return the seed of the random source, and the limits and treatment of new waypoints.

    ``x``, ``y`` and ``altitude`` are the highest values of a new waypoint. With ``avoid_ground``,
    which needs a checker, a new waypoint in the ground is drawn again; if no draw is above the
    ground, the mutation is skipped.
    """
    return Layout(
        (
            Field("seed", SEED_BITS, "any", "Seed of the random source"),
            Field("x", 16, "0 … map_size − 1", "Highest x of a new waypoint"),
            Field("y", 16, "0 … map_size − 1", "Highest y of a new waypoint"),
            Field("altitude", 16, "0 … blocked − 1", "Highest altitude of a new waypoint"),
            Field("avoid_ground", 1, "0; 1 with a checker", "Draw a waypoint in the ground again"),
        )
    )


def write_request(config: Config) -> Layout:
    """Return the first slot; the waypoints of one or more paths follow."""
    return Layout((Field("slot", 8, _SLOTS, "First slot"),))


def read_request(config: Config) -> Layout:
    """Return the first slot and the number of slots, 1 or more."""
    return Layout(
        (
            Field("slot", 8, _SLOTS, "First slot"),
            Field("count", 8, "1 … population − slot", "Slots"),
        )
    )


def generate_request(config: Config, mode: LinkMode) -> Layout:
    """Return the link mode and, in all modes except POPULATION, the slots from best to worst."""
    order = (
        ()
        if mode is LinkMode.POPULATION
        else numbered(
            "slot",
            config.population,
            8,
            _SLOTS,
            "Slots from the best path to the worst: each exactly once",
        )
    )
    return Layout((Field("mode", 8, "link mode", "Form of request and reply"), *order))


@functools.lru_cache
def map_request(config: Config) -> Layout:
    """Return the south-western cell and the size of a rectangle; the cells follow by rows."""
    return Layout(
        (
            Field("x", 16, "0 … map_size − 1", "Westernmost column"),
            Field("y", 16, "0 … map_size − 1", "Southernmost row"),
            Field("width", 16, "1 … map_size − x", "Columns"),
            Field("height", 16, "1 … map_size − y", "Rows"),
        )
    )


@functools.lru_cache
def coded_map_request(config: Config) -> Layout:
    """Return a rectangle of at most 64 columns, and the bits of a remainder; coded cells follow.

    The cells follow by rows, the lowest bit of a byte first. The *rise* of a cell is its altitude
    less the altitude of the cell to the west, or in the first column the cell to the south; the
    first cell of all counts from 0. The rise is predicted to be the rise of the cell to the south,
    and 0 in the first row and the first column. All numbers are modulo ``2**altitude_bits``. The
    error e of the prediction, as a signed number, becomes ``2 e`` if it is 0 or more, and
    ``-2 e - 1`` otherwise: as many ones as its quotient by ``2**remainder_bits``, a zero, and the
    remainder in ``remainder_bits`` bits, the lowest first. Instead of a quotient of 15 or more, 15
    ones and the altitude follow.
    """
    return Layout(
        (
            Field("x", 16, "0 … map_size − 1", "Westernmost column"),
            Field("y", 16, "0 … map_size − 1", "Southernmost row"),
            Field("width", 16, "1 … 64, up to map_size − x", "Columns"),
            Field("height", 16, "1 … map_size − y", "Rows"),
            Field("remainder_bits", 8, "0 … altitude_bits − 1", "Bits of a remainder"),
        )
    )


def check_request(config: Config) -> Layout:
    """Return the :class:`CheckFlag`; the points follow, 2 to ``max_waypoints + 2`` of them."""
    return Layout((Field("flags", 8, "0 … 3", "Check flags"),))


def check_paths_request(config: Config) -> Layout:
    """Return the slots to check, :class:`CheckFlag`, and the common ends of all paths."""
    return Layout(
        (
            Field("slot", 8, _SLOTS, "First slot"),
            Field("count", 8, "1 … population − slot", "Slots"),
            Field("flags", 8, "0 … 3", "Check flags"),
            sized(config, "start", "waypoint_bits", "a waypoint", "First point of every path"),
            sized(config, "goal", "waypoint_bits", "a waypoint", "Last point of every path"),
        )
    )


def results_request(config: Config) -> Layout:
    """Return the first path, 0 for the first of the latest check, and the number of paths."""
    return Layout(
        (
            Field("path", 8, "0 … paths − 1", "First path of the latest check"),
            Field("count", 8, "1 … paths − path", "Paths"),
        )
    )


def info_reply(config: Config) -> Layout:
    """Return version and build, whose place never changes, then session and configuration."""
    return Layout(
        (
            Field("version", 8, "1 … 255", "Version of the protocol"),
            Field("build_id", 32, "any", "Fingerprint of the configuration; a host may ignore it"),
            Field("session", 8, "0 … 255", "The open session"),
            Field("population", 16, "power of two, 4 … 256", "Slots"),
            Field("children", 8, "even, 4 or more", "Paths bred in each generation"),
            Field("elites", 8, "1 or more", "Best paths that are always kept"),
            Field("survivors", 8, "1 or more", "Other paths that are kept, drawn at random"),
            Field("perturbs", 8, "1 or more", "Mutators that move a waypoint"),
            Field("inserts", 8, "1 or more", "Mutators that insert a waypoint"),
            Field("deletes", 8, "1 or more", "Mutators that delete a waypoint"),
            Field(
                "max_waypoints", 8, "3 … 64", "Waypoints of the longest path; the shortest has 2"
            ),
            Field("map_size", 16, "power of two, 8 … 4096", "Cells along each edge of the map"),
            Field("coarse_factor", 16, "power of two", "Cells along the edge of a coarse cell"),
            Field("altitude_bits", 8, "4 … 16", "Width of an altitude"),
            Field(
                "box_percent", 8, "1 … 100", "Edge of the mutation box, percent of the map's edge"
            ),
            Field("rank_survivors", 8, "0, 1", "1: survivors are drawn by rank; 0: uniformly"),
            Field("clock_hz", 32, "1 or more", "Clock of the chip, hertz"),
            Field(
                "clocks_per_bit",
                16,
                "4 … 65535, or 0",
                "Cycles of a bit on the line; 0: a byte-wide port, a cycle for each byte",
            ),
            Field("receive_buffer", 16, "power of two, 256 … 32768", "Credit in bytes, see above"),
            Field("core", 8, "0, 1, 2", "Genetic core: 0 none, 1 paper, 2 planner"),
            Field("checker", 8, "see below", "Build of the collision checker"),
            Field("lanes", 8, "1, 2, 4, 8, 16", "Cells checked in a cycle"),
            Field("memory_latency", 8, "1, 2", "Cycles from an address of the map to its data"),
            Field("redraws", 8, "0 … 7", "Further draws of a new waypoint that lies in the ground"),
            Field("point_cycles", 8, "1, 2", "Cycles of a point in the scorer of the planner core"),
        )
    )


def info_values(config: Config) -> dict[str, int]:
    """Return the values of :func:`info_reply`, except for the session, which the chip fills in."""
    fields = {name for name, _ in info_reply(config).fields}
    values = {name: getattr(config, name) for name in fields if hasattr(config, name)}
    return values | {
        "version": VERSION,
        "rank_survivors": int(config.survivor_selection is SurvivorSelection.RANK),
        "core": _CORES.index(config.core),
        "checker": _CHECKERS.index(config.checker),
    }


def config_from_info(values: dict[str, int]) -> Config:
    """Return the configuration that :func:`info_reply`'s ``values`` describe.

    Raises
    ------
    ValueError
        If no configuration has these values.
    """
    apart = {"version", "build_id", "session", "rank_survivors", "core", "checker"}
    for name, designs in (("core", _CORES), ("checker", _CHECKERS)):
        if values[name] >= len(designs):
            raise ValueError(f"{name.title()} must be below {len(designs)}, not {values[name]}")
    return Config(
        survivor_selection=(
            SurvivorSelection.RANK if values["rank_survivors"] else SurvivorSelection.UNIFORM
        ),
        core=_CORES[values["core"]],
        checker=_CHECKERS[values["checker"]],
        **{name: values[name] for name in set(values) - apart},
    )


@functools.lru_cache
def status_reply(config: Config) -> Layout:
    """Return the state, the eight latest states, the sticky errors, and the progress of the core.

    ``history`` has 4 bits per state, the latest lowest. ``crossover``, ``mutation`` and ``update``
    are cycles of the latest generation.

    A chip with the planner core instead has fields of the latest run: ``running``, 1 until the run
    ends; its ``cycles``; the ``key`` of its best path yet, in the form of
    :data:`pathgene.hdl.protocol.planner.VALUE_BITS`; and the cycles of its units. ``generation``
    counts the generations of the run. Each field is consistent in itself, and final when
    ``running`` is 0.
    """
    latest = (
        Field("crossover", 16, "cycles", "Crossover of the latest generation"),
        Field("mutation", 16, "cycles", "Mutation of the latest generation"),
        Field("update", 16, "cycles", "Population update of the latest generation"),
    )
    run = (
        Field("running", 8, "0, 1", "1: the run is not over"),
        Field("cycles", 32, "modulo 2³²", "Cycles of the latest run"),
        Field("key", 32, "a key", "Key of the best path, class 3 if there is none"),
        *(Field(unit, 32, "modulo 2³²", _UNITS[unit]) for unit in UNITS),
    )
    generations = "Generations of the latest run, of all islands"
    if not config.planner_core:
        generations = "Generations since START"
    return Layout(
        (
            Field("state", 8, "a state", "State of the chip: always TRANSMIT, since it replies"),
            Field("history", 32, "8 states", "Latest eight states, 4 bits each, the latest lowest"),
            Field("errors", 8, "sticky errors", "Errors since reset or CLEAR"),
            Field("generation", 32, "modulo 2³²", generations),
            *(run if config.planner_core else latest),
        )
    )


def counters_reply(config: Config) -> Layout:
    """Return every :class:`Counter`, 48 bits each.

    Each counter is consistent in itself; counters still running while the reply is built are read a
    few cycles apart. The bytes sent do not include this answer.
    """
    return Layout(
        tuple(
            Field(counter.value, COUNTER_BITS, "modulo 2⁴⁸", _COUNTERS[counter])
            for counter in Counter
        )
    )


def survivors_reply(config: Config) -> Layout:
    """Return the survivors' former slots, which precede the children in :data:`LinkMode.RANK`."""
    return Layout(
        numbered(
            "survivor", config.survivors, 8, _SLOTS, "Slot of a survivor before this generation"
        )
    )


def recipe_reply(config: Config) -> Layout:
    """Return the choices of a generation, and the CRC-32 of the new population.

    ``parent`` and ``survivor`` are slots before the update. Each mutator has a flag that says
    whether its mutation was applied, its child, and the index of the waypoint; a mutator that makes
    a waypoint has the new waypoint, too. See :class:`pathgene.hdl.protocol.breeding.Recipe`.
    """
    mutations: list[tuple[str, int]] = []
    for i in range(config.mutators):
        mutations += [
            Field(f"applied_{i}", 1, "0, 1", "1: the mutation was applied"),
            sized(config, f"child_{i}", "child_bits", "0 … children − 1", "Child of the mutator"),
            sized(
                config,
                f"index_{i}",
                "index_bits",
                "0 … max_waypoints − 1",
                "Waypoint of that child",
            ),
        ]
    return Layout(
        (
            *numbered(
                "parent",
                config.crossovers,
                config.slot_bits,
                _SLOTS,
                "Slot of a parent before this generation",
                "slot_bits",
            ),
            *numbered(
                "survivor",
                config.survivors,
                config.slot_bits,
                _SLOTS,
                "Slot of a survivor before this generation",
                "slot_bits",
            ),
            *mutations,
            *numbered(
                "waypoint",
                config.patches,
                config.waypoint_bits,
                "a waypoint",
                "New waypoint, without its last bit",
                "waypoint_bits",
            ),
            Field(
                "checksum", 32, "CRC-32", "CRC of the new population, as READ returns all its slots"
            ),
        )
    )


def check_reply(config: Config) -> Layout:
    """Return the totals of a check: cycles of the checker, reads of the map, cells checked."""
    return Layout(
        (
            Field("cycles", 32, "modulo 2³²", "Cycles of the checker"),
            Field("reads", 32, "modulo 2³²", "Addresses given to the map's memory"),
            Field("cells", 32, "modulo 2³²", "Cells checked, of each path up to its first hit"),
        )
    )


def path_record(config: Config) -> Layout:
    """Return the collision flag of a path and the number of :func:`entry_record` in its result."""
    return Layout(
        (
            Field("collision", 1, "0, 1", "1: the path collides, and a hit record follows"),
            Field("entries", 7, "0 … 127", "Entry records that follow; 0 unless counting"),
        )
    )


def hit_record(config: Config) -> Layout:
    """Return the first colliding segment and cell, which follow :func:`path_record` of a collision.

    ``x`` and ``y`` are in cells of the map that the cell belongs to, the coarse map if ``coarse``.
    ``cells`` is the number of cells checked, from the first cell of the path to the colliding one.
    """
    return Layout(
        (
            sized(
                config,
                "segment",
                "segment_bits",
                "0 … max_waypoints",
                "Segment, 0 the one from the path's first point",
            ),
            Field("coarse", 1, "0, 1", "1: x and y are a cell of the coarse map"),
            sized(config, "x", "coordinate_bits", "0 … map_size − 1", "Column of the first hit"),
            sized(config, "y", "coordinate_bits", "0 … map_size − 1", "Row of the first hit"),
            sized(config, "cells", "path_cells_bits", "1 or more", "Cells checked up to this one"),
        )
    )


def entry_record(config: Config) -> Layout:
    """Return the counts of colliding cells of one segment: terrain and blocked."""
    return Layout(
        (
            sized(
                config,
                "segment",
                "segment_bits",
                "0 … max_waypoints",
                "Segment, 0 the one from the path's first point",
            ),
            sized(config, "terrain", "segment_cells_bits", "0 … map_size", "Its cells in terrain"),
            sized(config, "nofly", "segment_cells_bits", "0 … map_size", "Its blocked cells"),
        )
    )
