"""The file ``QGC WPL 110`` that Mission Planner, MAVProxy and QGroundControl read.

It holds a mission, or a fence: circles and corners of polygons to stay in or to keep out of.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from pathgene.host.errors import InputError
from pathgene.host.formats.areas import check_degrees
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Feature, LeftOut, Position, Read, label
from pathgene.host.formats.flight_plan import WAYPOINT, FlightPlan, Item
from pathgene.host.formats.places import number_text
from pathgene.host.formats.track import Track
from pathgene.host.numeric import parse


__all__ = ["features", "recognises", "waypoints_text", "write"]

_FRAME_GLOBAL = 0
# Commands of fences in MAVLink, MAV_CMD_NAV_FENCE_*: the corners of polygons and the circles to
# stay in and to keep out of.
_RETURN_POINT = 5000
_CORNERS = {5001: True, 5002: False}
_CIRCLES = {5003: True, 5004: False}


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
            if len(words) != 12 or command != int(command):
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
