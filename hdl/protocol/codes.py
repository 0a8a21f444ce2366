"""Codes of commands, answers, states, errors and counters."""

from __future__ import annotations

import enum


__all__ = [
    "COUNTER_BITS",
    "UNITS",
    "CheckFlag",
    "ChipState",
    "Command",
    "Counter",
    "LinkMode",
    "Status",
    "StickyError",
]

#: Width of every :class:`Counter`.
COUNTER_BITS = 48

#: Units of the planner core whose cycles a run counts.
UNITS = ("breed", "score", "walk", "sort", "wavefront")


class Command(enum.IntEnum):
    """Code of a request."""

    #: Version and configuration of the chip: :func:`info_reply`. Plain, needs no session.
    INFO = 1
    #: Open the session named in the header; the expected sequence number becomes 0.
    OPEN = 2
    #: State, generation, sticky errors: :func:`status_reply`.
    STATUS = 3
    #: Seed, limits, generation 0: :func:`start_request`. START, WRITE, GENERATE and READ are
    #: unknown to a chip without the paper core.
    START = 4
    #: Paths into consecutive slots: :func:`write_request`, then the waypoints.
    WRITE = 5
    #: One generation: :func:`generate_request`; the reply depends on the :class:`LinkMode`.
    GENERATE = 6
    #: Paths of consecutive slots: :func:`read_request`; the reply is their waypoints.
    READ = 7
    #: Cycles and bytes since reset: :func:`counters_reply`.
    COUNTERS = 8
    #: Clear the sticky errors.
    CLEAR = 9
    #: A rectangle of the map: :func:`map_request`, then its cells. A chip without a checker knows
    #: neither MAP, CHECK, CHECK_PATHS nor RESULTS; one with the planner core knows only MAP.
    MAP = 10
    #: One path against the map: :func:`check_request`, then its points, from the aircraft to the
    #: goal, in the form of a path; the reply is :func:`check_reply`, then the results.
    CHECK = 11
    #: Paths of consecutive slots against the map: :func:`check_paths_request`; the reply is as for
    #: CHECK. Also unknown to a chip without the paper core.
    CHECK_PATHS = 12
    #: Results of the latest check again: :func:`results_request`; the reply is the results.
    RESULTS = 13
    #: A problem: :func:`pathgene.hdl.protocol.planner.problem_request`. It invalidates the paths
    #: for BEST; the population stays for a warm run. PROBLEM to GUIDE are unknown to a chip without
    #: the planner core.
    PROBLEM = 14
    #: A run on the problem: :func:`pathgene.hdl.protocol.runs.run_request`. The answer arrives when
    #: it begins.
    RUN = 15
    #: End the run with its current generation. Without a run, nothing happens.
    STOP = 16
    #: Paths of the latest run, the best first: :func:`pathgene.hdl.protocol.runs.pack_best`.
    BEST = 17
    #: Block the corners of a shape: :func:`pathgene.hdl.protocol.planner.no_fly_request`. The
    #: answer arrives when it is drawn.
    BLOCK = 18
    #: A waypoint of the guide, a path of the host along which a run may begin:
    #: :func:`pathgene.hdl.protocol.runs.guide_request`. The guide stays until it is written again.
    GUIDE = 19
    #: A rectangle of the map like MAP, in fewer bytes:
    #: :func:`pathgene.hdl.protocol.messages.coded_map_request`, then its coded cells. Unknown to a
    #: chip without the planner core, too.
    CODED_MAP = 20


class Status(enum.IntEnum):
    """Code of an answer."""

    OK = 0
    #: Executed before the latest command: not executed again, and the answer is not repeated.
    DUPLICATE = 1
    #: Not the next command. The answer carries the expected sequence number.
    OUT_OF_ORDER = 2
    #: The session is not open.
    NO_SESSION = 3
    #: No such command.
    UNKNOWN_COMMAND = 4
    #: The payload is shorter or longer than the command's.
    BAD_LENGTH = 5
    #: A value is outside its range: slot, number of paths, waypoint count, order not a permutation.
    BAD_VALUE = 6
    #: A run is in progress: PROBLEM, RUN, MAP, CODED_MAP, BLOCK, GUIDE and BEST must wait for its
    #: end; STOP ends it.
    BUSY = 7


class LinkMode(enum.IntEnum):
    """Contents of the request and reply of a generation."""

    #: The population is already sorted. The reply is the whole new population.
    POPULATION = 0
    #: The request carries the order of the slots, the reply the survivors' slots and the children.
    RANK = 1
    #: The request is as in RANK. The reply is a recipe (:func:`recipe_reply`): the choices of the
    #: generation, and new waypoints only.
    RECIPE = 2


class CheckFlag(enum.IntFlag):
    """Options of a check."""

    #: Count the colliding cells of every segment instead of stopping at the first.
    COUNT = 1
    #: Answer only with :func:`check_reply`.
    BRIEF = 2


class ChipState(enum.IntEnum):
    """State of the control unit (*allaire-2008*, section 4.2)."""

    LISTEN = 0
    RECEIVE = 1
    CROSSOVER = 2
    MUTATE = 3
    UPDATE = 4
    TRANSMIT = 5
    #: The collision checker is on.
    CHECK = 6


class StickyError(enum.IntFlag):
    """Errors that the chip has seen since the last CLEAR."""

    #: A byte without a stop bit.
    FRAMING = 1
    #: A frame was discarded because the receive buffer was full.
    OVERRUN = 2
    #: A frame's CRC was wrong.
    CRC = 4
    #: A frame was too short, or its COBS code broken.
    MALFORMED = 8
    #: A command was refused with UNKNOWN_COMMAND, BAD_LENGTH, BAD_VALUE or BUSY.
    REFUSED = 16


class Counter(enum.StrEnum):
    """Counters of the chip since reset, in the order of :func:`counters_reply`."""

    #: Cycles. "clocks" is the key in ``summary.json`` and in the golden frames, which scripts read.
    CYCLES = "clocks"
    #: Cycles in which a frame was being received or a command was being taken.
    RECEIVE = "receive"
    #: Cycles of each unit.
    CROSSOVER = "crossover"
    MUTATION = "mutation"
    UPDATE = "update"
    #: Cycles in which an answer was being made or was on the line.
    TRANSMIT = "transmit"
    #: Cycles of the longest generation since the latest START, from the first cycle of the
    #: crossover to the new population.
    LONGEST = "longest"
    #: Generations executed, or bred in runs.
    GENERATIONS = "generations"
    #: Mutations that a length limit forbade.
    REFUSED_MUTATIONS = "refused_mutations"
    #: Bytes on the line, both ways, delimiters and damaged frames included.
    BYTES_RECEIVED = "bytes_received"
    BYTES_SENT = "bytes_sent"
    #: Cycles of the collision checker: for each path, from its first point or from the previous
    #: verdict, whichever is later, to its verdict.
    FEASIBILITY = "feasibility"
    #: Cells checked: in each path, the cells up to the first colliding one.
    CELLS = "cells"
    #: Reads of the map's memory by the checker.
    READS = "reads"
    #: Paths checked.
    PATHS = "paths"
    #: Repeated draws of new waypoints whose earlier draws lay in the ground.
    REDRAWN = "redrawn"
    #: Mutations left out because every draw of the new waypoint lay in the ground.
    LEFT_OUT = "left_out"
