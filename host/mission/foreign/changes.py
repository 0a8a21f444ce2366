"""Changes of a mended mission, compared with the mission before."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
import pyproj

from pathgene.host.formats.mission_items import MissionItem
from pathgene.host.mission.foreign.commands import CIRCLES, Command, radius_place
from pathgene.host.mission.foreign.draft import Draft


__all__ = ["Change", "changes"]

_EARTH = pyproj.Geod(ellps="WGS84")
_COMPASS = (
    *("north", "north-east", "east", "south-east"),
    *("south", "south-west", "west", "north-west"),
)
# Groups of inserted waypoints of this size are a planner's detour.
_DETOUR = 3


@dataclass(frozen=True)
class Change:
    """A change of a mission.

    Parameters
    ----------
    kind : str
        ``raise``, ``lower``, ``move``, ``widen``, ``insert``, ``detour`` or ``remove``.
    item : str
        The part that changes, with its number before the changes, such as ``item 6``; of inserted
        waypoints, the item before them.
    metres : float
        Metres of the change: of a raise, a move, a radius, or of inserted waypoints the length of
        the way through them less the straight one.
    sentence : str
        The change in words.
    places : tuple of (float, float, float)
        Latitude, longitude and height in the frame of its item, of each changed place.
    """

    kind: str
    item: str
    metres: float
    sentence: str
    places: tuple[tuple[float, float, float], ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Return plain JSON values."""
        return {
            "kind": self.kind,
            "item": self.item,
            "metres": self.metres,
            "places": [list(place) for place in self.places],
            "sentence": self.sentence,
        }


def changes(draft: Draft) -> list[Change]:
    """Return the changes of a draft in the order of the file."""
    return [*_of_items(draft), *_of_rally(draft)]


def _of_items(draft: Draft) -> Iterator[Change]:
    source, word = draft.source.items, draft.source.word
    last, expected = "the beginning", 0
    for is_new, group in groupby(draft.entries, key=lambda entry: entry.place is None):
        entries = list(group)
        if is_new:
            yield _inserted(draft, last, [entry.item for entry in entries])
            continue
        for entry in entries:
            assert entry.place is not None
            for gone in source[expected : entry.place]:
                yield _removed(f"{word} {gone.number}", gone)
            expected = entry.place + 1
            before = source[entry.place]
            last = f"{word} {before.number}"
            yield from _changed(last, before, entry.item)
    for gone in source[expected:]:
        yield _removed(f"{word} {gone.number}", gone)


def _of_rally(draft: Draft) -> Iterator[Change]:
    for number, (before, after) in enumerate(
        zip(draft.source.rally, draft.rally, strict=True), start=1
    ):
        yield from _different(f"rally point {number}", before, after)


def _changed(name: str, before: MissionItem, after: MissionItem) -> Iterator[Change]:
    """Yield the changes of an item; the height of a moved one may change with the ground."""
    yield from _different(
        name,
        (before.lat, before.lon, before.alt_m or 0.0),
        (after.lat, after.lon, after.alt_m or 0.0),
    )
    if before.command in CIRCLES and before.params != after.params:
        at = radius_place(before.command)
        radius_m = abs(after.params[at] or 0.0)
        wider_m = radius_m - abs(before.params[at] or 0.0)
        text = f"widened the circle of {name} by {wider_m:.0f} m, to {radius_m:.0f} m."
        yield Change("widen", name, wider_m, text, _place(after))


def _place(item: MissionItem) -> tuple[tuple[float, float, float], ...]:
    """Return the place of an item, if it has one."""
    return () if item.lat is None else ((item.lat, item.lon or 0.0, item.alt_m or 0.0),)


def _different(
    name: str,
    before: tuple[float | None, float | None, float],
    after: tuple[float | None, float | None, float],
) -> Iterator[Change]:
    place = (after[0] or 0.0, after[1] or 0.0, after[2])
    is_moved = before[:2] != after[:2]
    if is_moved:
        bearing, _, metres = _EARTH.inv(before[1], before[0], after[1], after[0])
        compass = _COMPASS[round(bearing / 45) % 8]
        text = f"moved {name} by {metres:.0f} m to the {compass} ({round(bearing) % 360} degrees)"
        yield Change("move", name, float(metres), f"{text}.", (place,))
    up_m = after[2] - before[2]
    if up_m:
        kind = "raise" if up_m > 0 else "lower"
        text = f"{kind}{'d' if kind == 'raise' else 'ed'} {name} by {abs(up_m):.0f} m"
        yield Change(kind, name, abs(up_m), f"{text}, to {after[2]:.1f} m.", (place,))


def _removed(name: str, item: MissionItem) -> Change:
    return Change("remove", name, 0.0, f"left {name} out.", _place(item))


def _inserted(draft: Draft, last: str, items: list[MissionItem]) -> Change:
    """Return the change of inserted waypoints."""
    places = tuple((item.lat or 0.0, item.lon or 0.0, item.alt_m or 0.0) for item in items)
    listed = ", ".join(f"{lat:.6f} {lon:.6f} at {alt:.1f} m" for lat, lon, alt in places)
    count = f"{len(items)} waypoint{'s' if len(items) > 1 else ''}"
    kind = "detour" if len(items) >= _DETOUR else "insert"
    verb = "led around by" if kind == "detour" else "inserted"
    return Change(
        kind, last, _longer_m(draft, items), f"{verb} {count} after {last}: {listed}.", places
    )


def _longer_m(draft: Draft, items: list[MissionItem]) -> float:
    """Return the length of the way through new items less the straight one, over the ground."""
    listed = [entry.item for entry in draft.entries]
    at = next(place for place, item in enumerate(listed) if item is items[0])
    flown = [
        item for item in listed if item.lat is not None and item.command != Command.RETURN_TO_LAUNCH
    ]
    at = next(place for place, item in enumerate(flown) if item is items[0])
    way = flown[max(at - 1, 0) : at + len(items) + 1]
    lat = np.array([item.lat for item in way], float)
    lon = np.array([item.lon for item in way], float)
    straight = _EARTH.line_length(lon[[0, -1]], lat[[0, -1]])
    return float(max(_EARTH.line_length(lon, lat) - straight, 0.0))
