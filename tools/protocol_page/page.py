"""The protocol page: a template filled with tables of layouts and worked frames."""

from __future__ import annotations

import enum
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import Enum
from pathlib import Path
from typing import Any

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.protocol import messages, planner, runs
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, CRC_BYTES, frame_crc
from pathgene.hdl.protocol.codes import CheckFlag, ChipState, Command, LinkMode, Status, StickyError
from pathgene.hdl.protocol.layout import Field, Layout
from pathgene.hdl.protocol.messages import info_values
from tools.protocol_page.frames import DEFAULT, PLANNER, SMALL
from tools.protocol_page.segments import Segment, split_reply, split_request, waypoint_layout


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
    Command.CODED_MAP: ("write a rectangle of the map", "fields, coded cells", "none"),
    Command.GUIDE: ("a waypoint of a path to begin near", "fields", "none"),
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


#: Layout of each message by the name of its function; its fields have texts.
MESSAGES: dict[str, Callable[[Config], Layout]] = {
    **vars(messages),
    **vars(planner),
    **vars(runs),
    "waypoint": waypoint_layout,
    "planner_status_reply": lambda config: messages.status_reply(
        config.replace(core="planner", checker="parallel")
    ),
    "generate_request": lambda config: messages.generate_request(config, LinkMode.RANK),
}

_TEMPLATE = Path(__file__).with_name("page.md")
#: Sizes derived from the configuration, in the order of the table on the page.
_SIZES = {
    "coordinate_bits": "⌈log₂ map_size⌉",
    "waypoint_bits": "2 · coordinate_bits + altitude_bits",
    "waypoint_bytes": "⌈(waypoint_bits + 1) / 8⌉",
    "blocked_altitude": "2^altitude_bits − 1",
    "slot_bits": "⌈log₂ population⌉",
    "child_bits": "⌈log₂ children⌉",
    "index_bits": "⌈log₂ max_waypoints⌉",
    "crossovers": "children / 2",
    "mutators": "perturbs + inserts + deletes",
    "patches": "perturbs + inserts",
    "segment_bits": "⌈log₂ (max_waypoints + 1)⌉",
    "segment_cells_bits": "coordinate_bits + 1",
    "path_cells_bits": "⌈log₂ ((max_waypoints + 1) · map_size + 1)⌉",
}


def protocol_page(frames: dict[str, Any]) -> str:
    """Return the content of ``docs/protocol.md``; ``frames`` are the golden frames."""
    chips = {chip["name"]: chip for chip in frames["chips"]}
    small, planner = (
        {exchange["name"]: exchange for exchange in chips[name]["exchanges"]}
        for name in ("small", "planner")
    )
    makers: dict[str, Callable[[str], str]] = {
        "commands": lambda _: _commands(),
        "codes": _codes,
        "layout": _layout_table,
        "sizes": lambda _: _size_table(),
        "checkers": lambda _: _checkers(),
        "example": lambda name: _example(SMALL, small[name]),
        "run": lambda name: _example(PLANNER, planner[name]),
        "board": lambda name: chips[name]["board"],
        "version": lambda _: str(frames["protocol_version"]),
        "waypoint": _waypoint,
        "unframe": lambda name: _unframe(small[name]["request"]),
        "hex": lambda name: small[name]["request"]["frame"],
    }

    def fill(match: re.Match[str]) -> str:
        kind, _, name = match[1].partition(":")
        return makers[kind](name)

    return re.sub(r"\{\{([^}]+)\}\}", fill, _TEMPLATE.read_text())


def _table(head: tuple[str, ...], rows: Sequence[tuple[object, ...]]) -> str:
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join(f"| {' | '.join(map(str, line))} |" for line in lines)


def _unframe(said: dict[str, Any]) -> str:
    frame, body = bytes.fromhex(said["frame"]), bytes.fromhex(said["body"])
    crc = frame_crc(body, plain=said["plain"]).to_bytes(CRC_BYTES, "little")
    right = frame_crc(body, plain=True).to_bytes(CRC_BYTES, "little")
    rows = [
        ("on the line", frame.hex(" ")),
        ("without COBS and delimiter", (body + crc).hex(" ")),
        ("body", body.hex(" ")),
        ("CRC as sent", crc.hex(" ")),
        ("CRC, each byte XORed with the version", right.hex(" ")),
    ]
    return _table(("Part", "Hex"), [(part, f"`{shown}`") for part, shown in rows])


def _waypoint(values: str) -> str:
    layout = waypoint_layout(DEFAULT)
    names = [name for name, _ in layout.fields]
    fields = dict(zip(names, map(int, values.split(",")), strict=True))
    return layout.pack(**fields).hex(" ")


def _commands() -> str:
    rows = []
    for command in Command:
        purpose, request, reply = COMMANDS[command]
        link = f"[{command.name}](#{command.name.lower()})"
        rows.append((int(command), link, purpose, request, reply))
    return _table(("Code", "Command", "Purpose", "Request", "Reply"), rows)


def _codes(name: str) -> str:
    kind = next(kind for kind in CODES if kind.__name__ == name)
    texts = CODES[kind]
    if set(texts) != set(kind):
        raise ValueError(f"Codes of {name} must all have a text")
    flags = issubclass(kind, enum.Flag)
    rows = [(code.value, f"`{code.name}`", text) for code, text in texts.items()]
    return _table(("Bit value" if flags else "Code", "Name", "Meaning"), rows)


def _checkers() -> str:
    texts = {
        CheckerBuild.NONE: "no checker, no map",
        CheckerBuild.TWO_TIER: "two-tier: the first two segments on the map, the others coarsely",
        CheckerBuild.PARALLEL: "parallel: every segment on the map, `lanes` cells a cycle",
    }
    numbered = {
        info_values(DEFAULT.replace(checker=build, lanes=1))["checker"]: text
        for build, text in texts.items()
    }
    return "; ".join(f"{number}: {text}" for number, text in sorted(numbered.items()))


def _size_table() -> str:
    rows: list[tuple[object, ...]] = []
    for name, formula in _SIZES.items():
        rows.append((f"`{name}`", formula, getattr(DEFAULT, name), getattr(SMALL, name)))
    return _table(("Size", "Formula", "Default chip", "Example chip"), rows)


def _layout_table(name: str) -> str:
    """Return the table of one message, for the default chip."""
    layout_of = MESSAGES[name]
    for config in (DEFAULT, SMALL):
        _check_widths(config, name, _fields_of(name, layout_of(config)))
    places: dict[str, list[tuple[int, Field]]] = {}
    at = 0
    for field in _fields_of(name, layout_of(DEFAULT)):
        places.setdefault(field.base, []).append((at, field))
        at += field[1]
    in_bytes = all(bit % 8 == 0 for found in places.values() for bit, _ in found)
    rows = []
    for base, found in places.items():
        first, field = found[0]
        unit = 8 if in_bytes else 1
        offset, title = str(first // unit), f"`{base}`"
        if len(found) > 1:
            step = (found[1][0] - first) // unit
            stride = "i" if step == 1 else f"{step}·i"
            offset = f"{offset} + {stride}" if first else stride
            title = f"`{base}_i`, i = 0 … {len(found) - 1}"
        size = f"{field[1]} (`{field.size}`)" if field.size else str(field[1])
        rows.append((offset, size, title, field.values, field.meaning))
    total = layout_of(DEFAULT)
    same = total.size == layout_of(SMALL).size
    size = f"{total.size} byte{'s' * (total.size != 1)}{'' if same else ' on the default chip'}"
    head = ("Byte" if in_bytes else "Bit", "Bits", "Field", "Values", "Meaning")
    return f"{size}:\n\n{_table(head, rows)}"


def _fields_of(name: str, layout: Layout) -> list[Field]:
    """Return the fields of a message, all of which have a text."""
    bare = [field[0] for field in layout.fields if not isinstance(field, Field)]
    if bare:
        raise ValueError(f"Fields of {name} must have texts, unlike {', '.join(bare)}")
    return [field for field in layout.fields if isinstance(field, Field)]


def _check_widths(config: Config, name: str, fields: Sequence[Field]) -> None:
    for field in fields:
        if field.size is not None and getattr(config, field.size) != field[1]:
            raise ValueError(f"Width of {name}.{field.base} must be {field.size}, not {field[1]}")


def _example(config: Config, exchange: dict[str, Any]) -> str:
    request, reply = exchange["request"], exchange["reply"]
    parts = [f"*{exchange['about'][0].upper()}{exchange['about'][1:]}.*", ""]
    parts += [_frame("Request", request)]
    body = bytes.fromhex(request["body"])
    payload = body[BODY_HEADER_BYTES:]
    command = Command(request["code"])
    parts += ["", _fields(body, f"{command.name}", split_request(config, command, payload))]
    parts += ["", _frame("Reply", reply)]
    answer = bytes.fromhex(reply["body"])
    segments = split_reply(config, command, payload, answer[BODY_HEADER_BYTES:])
    parts += ["", _fields(answer, reply["status"], segments)]
    return "\n".join(parts)


def _frame(title: str, said: dict[str, Any]) -> str:
    shown = bytes.fromhex(said["frame"]).hex(" ")
    lines = [shown[at : at + 96].rstrip() for at in range(0, len(shown), 96)]
    return "\n".join([f"{title}:", "", "```text", *lines, "```"])


def _fields(body: bytes, code: str, segments: list[Segment]) -> str:
    """Return the table of a body: a row for each field, waypoint, record and list of cells."""
    rows: list[tuple[object, ...]] = [
        (0, f"{body[0]:02x}", "", "session", body[0]),
        (1, f"{body[1]:02x}", "", "sequence", body[1]),
        (2, f"{body[2]:02x}", "", "code", f"{body[2]}, {code}"),
    ]
    at = BODY_HEADER_BYTES
    for segment in segments:
        if segment.kind == "fields":
            rows += _field_rows(at, segment)
        else:
            values = ", ".join(f"{name} {value}" for name, value in segment.values.items())
            if segment.kind == "coded":
                values = "the cells"
            if segment.kind == "cells":
                values = ", ".join(map(str, segment.values.values()))
            rows.append(
                (_span(at, len(segment.data)), segment.data.hex(" "), "", segment.kind, values)
            )
        at += len(segment.data)
    return _table(("Byte", "Hex", "Bits", "Field", "Value"), rows)


def _field_rows(at: int, segment: Segment) -> Iterator[tuple[object, ...]]:
    bit = 0
    for (field, width), value in zip(segment.layout.fields, segment.values.values(), strict=True):
        first, last = bit // 8, (bit + width - 1) // 8
        aligned = bit % 8 == 0 and width % 8 == 0
        bits = "" if aligned else f"{bit} … {bit + width - 1}" if width > 1 else str(bit)
        hexed = segment.data[first : last + 1].hex(" ")
        yield _span(at + first, last - first + 1), hexed, bits, field, value
        bit += width


def _span(first: int, count: int) -> str:
    return str(first) if count == 1 else f"{first} … {first + count - 1}"
