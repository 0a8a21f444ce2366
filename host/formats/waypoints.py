"""The file ``QGC WPL 110`` that Mission Planner, MAVProxy and QGroundControl read.

It holds a mission, or a fence: circles and corners of polygons to stay in or to keep out of.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from pathgene.host.errors import InputError
from pathgene.host.formats.areas import check_degrees
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Feature, LeftOut, Position, Read, label
from pathgene.host.formats.flight_plan import WAYPOINT, FlightPlan, Item
from pathgene.host.formats.mission_items import ARDUPILOT, Entry, MissionFile, MissionItem
from pathgene.host.formats.places import number_text
from pathgene.host.formats.track import Track
from pathgene.host.numeric import parse


__all__ = [
    "changed",
    "features",
    "holds_mission",
    "mission",
    "recognises",
    "waypoints_text",
    "write",
]

_FRAME_GLOBAL = 0
# Commands of fences in MAVLink, MAV_CMD_NAV_FENCE_*: the corners of polygons and the circles to
# stay in and to keep out of.
_RETURN_POINT = 5000
_CORNERS = {5001: True, 5002: False}
_CIRCLES = {5003: True, 5004: False}
_RALLY_POINT = 5100
_COLUMNS = 12
_VERSION = "110"


def write(track: Track) -> bytes:
    """Return the flight plan of a track as a ``.waypoints`` file."""
    return waypoints_text(track.flown).encode()


def waypoints_text(plan: FlightPlan) -> str:
    """Return the content of a ``.waypoints`` file: row 0 is home, altitudes are AMSL."""
    home = Item(WAYPOINT, (0.0, 0.0, 0.0, 0.0), *plan.home)
    rows = [_row(number, item) for number, item in enumerate((home, *plan.items))]
    return "\n".join(("QGC WPL 110", *rows, ""))


def _row(number: int, item: Item) -> str:
    # The format cannot leave a number to the autopilot; its programs write 0 there.
    numbers = (*(param or 0.0 for param in item.params), item.lat, item.lon, item.alt_m)
    is_current = int(number == 0)
    return "\t".join(
        (
            f"{number}\t{is_current}\t{_FRAME_GLOBAL}\t{item.command}",
            *(number_text(value) for value in numbers),
            "1",
        )
    )


@dataclass(frozen=True)
class _FenceRow:
    """A row of a fence: its command, first parameter and position."""

    number: int
    command: int
    size: float
    position: Position


def recognises(content: Content) -> bool:
    """Return whether a text begins like a list of waypoints."""
    return re.match(r"QGC WPL \d", content.text.lstrip()) is not None


def holds_mission(content: Content) -> bool:
    """Return whether a text begins like a list of waypoints."""
    return recognises(content)


def mission(content: Content) -> MissionFile:
    """Return the mission: row 0 is home, and rows of fences and rally points are no items.

    Raises
    ------
    InputError
        If a row is bad, numbers do not rise, or no row is an item.
    """
    header, *lines = content.text.strip().splitlines()
    if header.split()[2] != _VERSION:
        raise InputError(
            f"its first line is {header[:40]!r}, whose columns may mean something else; save it as "
            f"QGC WPL {_VERSION}."
        )
    rows = []
    for line_number, line in enumerate(lines, start=2):
        if line.split() and not line.lstrip().startswith("#"):
            rows.append(_mission_row(line_number, line))
    fences = {_RETURN_POINT, *_CORNERS, *_CIRCLES}
    rally = [row for row in rows if row.command == _RALLY_POINT]
    items = [row for row in rows if row.command not in {_RALLY_POINT, *fences}]
    for before, after in pairwise(items):
        if after.number <= before.number:
            raise InputError(f"its item {after.number} follows item {before.number}.")
    home = items.pop(0) if items and items[0].number == 0 else None
    if not items:
        raise InputError("there is no item of a mission in it.")
    return MissionFile(
        "a list of waypoints (QGC WPL)",
        tuple(items),
        None if home is None or home.lat is None else (home.lat, home.lon or 0.0, home.alt_m),
        tuple((row.lat or 0.0, row.lon or 0.0, row.alt_m or 0.0) for row in rally),
        ARDUPILOT,
        any(row.command in fences for row in rows),
    )


def _mission_row(line_number: int, line: str) -> MissionItem:
    try:
        words = [parse(word) for word in line.split()]
        whole = [int(words[at]) for at in (0, 2, 3)]
        if len(words) != _COLUMNS or whole != [words[at] for at in (0, 2, 3)]:
            raise ValueError
    except (ValueError, IndexError):
        raise InputError(f"line {line_number} is no row of {_COLUMNS} numbers.") from None
    number, frame, command = whole
    first, second, third, fourth, lat, lon, alt_m, _ = words[4:]
    has_place = bool(lat or lon)
    return MissionItem(
        number,
        command,
        frame,
        (first, second, third, fourth),
        lat if has_place else None,
        lon if has_place else None,
        alt_m,
    )


def changed(
    content: Content, entries: Sequence[Entry], rally: Sequence[tuple[float, float, float]]
) -> bytes:
    """Return a list of waypoints with a changed mission; home, fences and comments stay.

    Parameters
    ----------
    content : Content
        A file from which :func:`mission` reads a mission.
    entries : sequence of Entry
        The items as they are to be written.
    rally : sequence of (float, float, float)
        As many rally points as the file has.
    """
    items = mission(content).items
    lines = content.text.strip().splitlines()
    after: dict[int, list[str]] = {}
    kept: dict[int, MissionItem] = {}
    last = 0
    for entry in entries:
        if entry.place is None:
            after.setdefault(last, []).append(_item_row(entry.item))
        else:
            last = entry.place
            kept[last] = entry.item
    written = [lines[0]]
    place = 0
    points = iter(rally)
    for number, line in enumerate(lines[1:], start=2):
        if not line.split() or line.lstrip().startswith("#"):
            written.append(line)
            continue
        row = _mission_row(number, line)
        if row.command == _RALLY_POINT:
            lat, lon, height_m = next(points)
            written.append(_replaced(line, {8: lat, 9: lon, 10: height_m}))
        elif place < len(items) and row == items[place]:
            written += _rows(line, row, kept.get(place), after.pop(place, []))
            place += 1
        else:
            written.append(line)
    ending = "\r\n" if "\r\n" in content.text else "\n"
    return ending.join((*written, "")).encode()


def _rows(
    line: str, before: MissionItem, item: MissionItem | None, following: list[str]
) -> Iterator[str]:
    """Yield the row of an item that stays, and the rows that follow it."""
    if item is not None:
        words: dict[int, float] = {0: item.number}
        if item.params != before.params:
            words |= {4 + at: each or 0.0 for at, each in enumerate(item.params)}
        if (item.lat, item.lon) != (before.lat, before.lon):
            words |= {8: item.lat or 0.0, 9: item.lon or 0.0}
        if item.alt_m != before.alt_m:
            words[10] = item.alt_m or 0.0
        yield _replaced(line, words)
    yield from following


def _replaced(line: str, words: dict[int, float]) -> str:
    """Return a row with other numbers in some columns; the rest stays as it was written."""
    was = line.split()
    new = [number_text(words[at]) if at in words else word for at, word in enumerate(was)]
    return "\t".join(
        word if parse(word) != parse(old) else old for word, old in zip(new, was, strict=True)
    )


def _item_row(item: MissionItem) -> str:
    numbers = (*item.params, item.lat, item.lon, item.alt_m)
    words = (number_text(value or 0.0) for value in numbers)
    return "\t".join((f"{item.number}\t0\t{item.frame}\t{item.command}", *words, "1"))


def features(content: Content) -> Iterator[Read]:
    """Yield the circles and polygons of a fence; waypoints are not areas.

    Raises
    ------
    InputError
        If no row belongs to a fence.
    """
    rows: list[_FenceRow] = []
    others = 0
    for number, line in enumerate(content.text.strip().splitlines()[1:], start=2):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        try:
            command, size, lat, lon = (parse(words[at]) for at in (3, 4, 8, 9))
            if len(words) != _COLUMNS or command != int(command):
                raise ValueError
        except (ValueError, IndexError):
            yield Bad(f"line {number}", "it is no row of 12 numbers.")
            continue
        if int(command) in _CORNERS or int(command) in _CIRCLES:
            rows.append(_FenceRow(number, int(command), size, (lon, lat)))
        elif int(command) != _RETURN_POINT:
            others += 1
    if not rows:
        raise InputError(
            "there is no fence in it, only waypoints; save the fence of the ground station instead."
        )
    yield from _fences(rows)
    if others > 1:
        yield LeftOut(f"{others - 1} waypoints", "a waypoint is not an area")


def _fences(rows: list[_FenceRow]) -> Iterator[Read]:
    """Yield the fences of the rows: each corner states the number of corners of its polygon."""
    number = at = 0
    while at < len(rows):
        row = rows[at]
        number += 1
        is_polygon = row.command in _CORNERS
        count = int(row.size) if is_polygon and 1 <= row.size <= len(rows) else 1
        part = rows[at : at + count]
        at += count
        try:
            yield _fence(number, part, count if is_polygon else 0)
        except InputError as error:
            yield Bad(label("fence", number), f"line {row.number}: {error}")


def _fence(number: int, part: list[_FenceRow], corners: int) -> Feature:
    row = part[0]
    ring = tuple(each.position for each in part)
    check_degrees(ring, "latitude comes first.")
    if corners:
        same = {(each.command, each.size) for each in part} == {(row.command, row.size)}
        if corners != row.size or len(part) != corners or not same:
            raise InputError(f"its polygon must have {row.size:g} corners of the same kind.")
        if len(set(ring)) < 3:
            raise InputError("a polygon must have three corners or more.")
    elif not row.size > 0:
        raise InputError(f"the radius of a circle must be above 0 m, not {row.size:g}.")
    keeps_in = (_CORNERS | _CIRCLES)[row.command]
    return Feature(
        number,
        f"outside of fence {number}" if keeps_in else "",
        (ring,),
        None if corners else row.size,
        kind="fence",
        keeps_in=keeps_in,
    )
