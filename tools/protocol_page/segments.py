"""Payloads split into the consecutive layouts of :mod:`pathgene.hdl.protocol`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import Command, LinkMode
from pathgene.hdl.protocol.layout import Field, Layout
from pathgene.hdl.protocol.messages import (
    check_paths_request,
    check_reply,
    check_request,
    coded_map_request,
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
from pathgene.hdl.protocol.runs import guide_request, run_request


@dataclass(frozen=True)
class Segment:
    """The part of a payload that has one layout."""

    #: ``fields``, ``waypoint``, ``cells``, ``coded``, ``path``, ``hit``, ``entry`` or ``key``.
    kind: str
    layout: Layout
    data: bytes

    @property
    def values(self) -> dict[str, int]:
        """Value of each field."""
        return self.layout.unpack(self.data)


_REQUESTS: dict[Command, Callable[[Config], Layout]] = {
    Command.START: start_request,
    Command.WRITE: write_request,
    Command.READ: read_request,
    Command.MAP: map_request,
    Command.CHECK: check_request,
    Command.CHECK_PATHS: check_paths_request,
    Command.RESULTS: results_request,
    Command.PROBLEM: problem_request,
    Command.RUN: run_request,
    Command.BLOCK: no_fly_request,
    Command.GUIDE: guide_request,
    Command.CODED_MAP: coded_map_request,
}
_REPLIES: dict[Command, Callable[[Config], Layout]] = {
    Command.INFO: info_reply,
    Command.STATUS: status_reply,
    Command.COUNTERS: counters_reply,
    Command.CHECK: check_reply,
    Command.CHECK_PATHS: check_reply,
}


def waypoint_layout(config: Config) -> Layout:
    """Return the fields of a waypoint as ``pack_paths`` of the protocol packs them."""
    return Layout(
        (
            Field(
                "x",
                config.coordinate_bits,
                "0 … map_size − 1",
                "Column of the map, from the west",
                "coordinate_bits",
            ),
            Field(
                "y",
                config.coordinate_bits,
                "0 … map_size − 1",
                "Row of the map, from the south",
                "coordinate_bits",
            ),
            Field(
                "altitude",
                config.altitude_bits,
                "0 … blocked − 1",
                "Altitude step",
                "altitude_bits",
            ),
            Field("last", 1, "0, 1", "1 ends the path"),
        )
    )


def split_request(config: Config, command: Command, payload: bytes) -> list[Segment]:
    """Return the segments of a request's payload."""
    if command is Command.GENERATE:
        return [Segment("fields", generate_request(config, LinkMode(payload[0])), payload)]
    if command not in _REQUESTS:
        return _nothing(command, "request", payload)
    layout = _REQUESTS[command](config)
    rest = payload[layout.size :]
    segments = [Segment("fields", layout, payload[: layout.size])]
    if command is Command.MAP:
        fields = segments[0].values
        count = fields["width"] * fields["height"]
        cells = Layout(tuple((f"cell_{i}", config.altitude_bits) for i in range(count)))
        segments.append(Segment("cells", cells, rest))
    elif command is Command.CODED_MAP:
        segments.append(Segment("coded", Layout((("coded_cells", 8 * len(rest)),)), rest))
    else:
        segments += _waypoints(config, rest)
    return segments


def split_reply(config: Config, command: Command, request: bytes, payload: bytes) -> list[Segment]:
    """Return the segments of the payload of the reply to a ``request``'s payload."""
    if command is Command.READ:
        return list(_waypoints(config, payload))
    if command is Command.RESULTS:
        return list(_results(config, payload))
    if command is Command.BEST:
        return list(_best(config, payload))
    if command is Command.GENERATE:
        mode = LinkMode(request[0])
        if mode is LinkMode.POPULATION:
            return list(_waypoints(config, payload))
        if mode is LinkMode.RECIPE:
            return [Segment("fields", recipe_reply(config), payload)]
        layout = survivors_reply(config)
        rest = payload[layout.size :]
        return [Segment("fields", layout, payload[: layout.size]), *_waypoints(config, rest)]
    if command not in _REPLIES:
        return _nothing(command, "reply", payload)
    layout = _REPLIES[command](config)
    segments = [Segment("fields", layout, payload[: layout.size])]
    return [*segments, *_results(config, payload[layout.size :])]


def _nothing(command: Command, message: str, payload: bytes) -> list[Segment]:
    """Return no segments, for a message without a payload."""
    if payload:
        raise ValueError(f"The {message} {command.name} has a payload, of which no layout is known")
    return []


def _waypoints(config: Config, packed: bytes) -> Iterator[Segment]:
    size = config.waypoint_bytes
    for at in range(0, len(packed), size):
        yield Segment("waypoint", waypoint_layout(config), packed[at : at + size])


def _best(config: Config, packed: bytes) -> Iterator[Segment]:
    key = Layout((("key", 32),))
    at, begins = 0, True
    while at < len(packed):
        kind, layout = ("key", key) if begins else ("waypoint", waypoint_layout(config))
        segment = Segment(kind, layout, packed[at : at + layout.size])
        yield segment
        begins = not begins and segment.values["last"] == 1
        at += layout.size


def _results(config: Config, packed: bytes) -> Iterator[Segment]:
    at = 0

    def take(kind: str, layout: Layout) -> Segment:
        nonlocal at
        at += layout.size
        return Segment(kind, layout, packed[at - layout.size : at])

    while at < len(packed):
        path = take("path", path_record(config))
        yield path
        if path.values["collision"]:
            yield take("hit", hit_record(config))
        for _ in range(path.values["entries"]):
            yield take("entry", entry_record(config))


def values_of(segments: list[Segment]) -> dict[str, Any]:
    """Return the ``fields``, ``paths``, ``keys``, cells and ``results`` in ``segments``."""
    said: dict[str, Any] = {}
    path: list[list[int]] = []
    for segment in segments:
        values = segment.values
        match segment.kind:
            case "fields":
                said["fields"] = values
            case "cells":
                said["cells"] = list(values.values())
            case "coded":
                said["coded_cells"] = segment.data.hex()
            case "waypoint":
                *waypoint, last = values.values()
                path.append(waypoint)
                if last:
                    said.setdefault("paths", []).append(path)
                    path = []
            case "key":
                said.setdefault("keys", []).append(values["key"])
            case "path":
                collision = bool(values["collision"])
                said.setdefault("results", []).append({"collision": collision, "entries": []})
            case "hit":
                said["results"][-1]["hit"] = values
            case _:
                said["results"][-1]["entries"].append(values)
    return said
