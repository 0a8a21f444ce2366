"""Texts of the protocol page for commands and codes; fields have their own texts next to them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum

from pathgene.hdl.config import Config
from pathgene.hdl.protocol import (
    CheckFlag,
    ChipState,
    Command,
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


__all__ = ["CODES", "COMMANDS", "MESSAGES"]


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


def _planner(config: Config) -> Config:
    """Return a chip with the planner core that has the sizes of ``config``."""
    return config.replace(core="planner", checker="parallel")


#: Layout of each message, whose fields have texts.
MESSAGES: Mapping[str, Callable[[Config], Layout]] = {
    "waypoint": waypoint_layout,
    "info_reply": info_reply,
    "status_reply": status_reply,
    "planner_status_reply": lambda config: status_reply(_planner(config)),
    "problem_request": problem_request,
    "run_request": run_request,
    "no_fly_request": no_fly_request,
    "start_request": start_request,
    "write_request": write_request,
    "read_request": read_request,
    "generate_request": lambda config: generate_request(config, LinkMode.RANK),
    "survivors_reply": survivors_reply,
    "recipe_reply": recipe_reply,
    "counters_reply": counters_reply,
    "map_request": map_request,
    "check_request": check_request,
    "check_paths_request": check_paths_request,
    "results_request": results_request,
    "check_reply": check_reply,
    "path_record": path_record,
    "hit_record": hit_record,
    "entry_record": entry_record,
}
