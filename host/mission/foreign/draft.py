"""A mission under repair: its items, their originals, and numbers and jumps that stay right."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from pathgene.host.formats.mission_items import Entry, MissionFile, MissionItem
from pathgene.host.formats.places import DEGREE_DECIMALS
from pathgene.host.mission.foreign.commands import CIRCLES, Command, radius_place
from pathgene.host.mission.foreign.course import Handle


__all__ = ["Draft"]

Place = tuple[float, float]


@dataclass(frozen=True)
class Draft:
    """A changed mission.

    Parameters
    ----------
    source : MissionFile
        The mission before all changes.
    entries : tuple of Entry
        Its items; their numbers and jumps are the source's until :attr:`file` renumbers them.
    rally : tuple of (float, float, float)
        Its rally points.
    """

    source: MissionFile
    entries: tuple[Entry, ...]
    rally: tuple[tuple[float, float, float], ...]

    @staticmethod
    def of(mission: MissionFile) -> Draft:
        """Return a mission without changes."""
        entries = (Entry(item, place) for place, item in enumerate(mission.items))
        return Draft(mission, tuple(entries), mission.rally)

    @cached_property
    def written(self) -> tuple[Entry, ...]:
        """The items with the numbers and targets of jumps that they have in the changed file.

        The numbers grow by the items that are inserted before, less the removed ones. A jump to a
        removed item leads to the next one.
        """
        numbers = [entry.item.number for entry in self.entries]
        shift = expected = 0
        for at, entry in enumerate(self.entries):
            if entry.place is None:
                shift += 1
                numbers[at] = numbers[at - 1] + 1 if at else self.source.items[0].number
                continue
            shift -= entry.place - expected
            expected = entry.place + 1
            numbers[at] = entry.item.number + shift
        targets = dict(self._targets(numbers))
        return tuple(
            replace(entry, item=_renumbered(entry.item, number, targets))
            for number, entry in zip(numbers, self.entries, strict=True)
        )

    def _targets(self, numbers: Sequence[int]) -> Iterator[tuple[int, int]]:
        """Yield the old and new numbers of the original items."""
        following = numbers[-1]
        at = len(self.entries) - 1
        for place in range(len(self.source.items) - 1, -1, -1):
            while at >= 0 and self.entries[at].place is None:
                at -= 1
            if at >= 0 and self.entries[at].place == place:
                following = numbers[at]
                at -= 1
            yield self.source.items[place].number, following

    @cached_property
    def file(self) -> MissionFile:
        """The changed mission."""
        items = tuple(entry.item for entry in self.written)
        return replace(self.source, items=items, rally=self.rally)

    @property
    def touched(self) -> frozenset[Handle]:
        """The parts of :attr:`file` that are new, or have another place, height or radius."""
        items = self.source.items
        found: set[Handle] = {
            ("item", entry.item.number)
            for entry in self.written
            if entry.place is None or _stated(entry.item) != _stated(items[entry.place])
        }
        pairs = enumerate(zip(self.source.rally, self.rally, strict=True), start=1)
        return frozenset(found | {("rally", number) for number, (a, b) in pairs if a != b})

    def raised(self, indices: Sequence[int], rally: Sequence[int], up_m: float) -> Draft:
        """Return it with items and rally points (from 0) higher, or lower, by some metres."""
        entries, points = list(self.entries), list(self.rally)
        for at in indices:
            item = entries[at].item
            higher = replace(item, alt_m=_tidy((item.alt_m or 0.0) + up_m))
            entries[at] = replace(entries[at], item=higher)
        for at in rally:
            lat, lon, height_m = points[at]
            points[at] = lat, lon, _tidy(height_m + up_m)
        return replace(self, entries=tuple(entries), rally=tuple(points))

    def widened(self, at: int, radius_m: float) -> Draft:
        """Return it with another radius of a circle, in its direction."""
        item = self.entries[at].item
        params = list(item.params)
        place = radius_place(item.command)
        params[place] = math.copysign(radius_m, params[place] or 0.0)
        first, second, third, fourth = params
        wide = replace(item, params=(first, second, third, fourth))
        entries = list(self.entries)
        entries[at] = replace(entries[at], item=wide)
        return replace(self, entries=tuple(entries))

    def placed(
        self, places: Mapping[int, Place], heights: Mapping[int, float], rally: Mapping[int, Place]
    ) -> Draft:
        """Return it with items and rally points at other places, and other heights of some."""
        entries, points = list(self.entries), list(self.rally)
        for at, (lat, lon) in places.items():
            moved = replace(entries[at].item, lat=_degrees(lat), lon=_degrees(lon))
            if at in heights:
                moved = replace(moved, alt_m=_tidy(heights[at]))
            entries[at] = replace(entries[at], item=moved)
        for at, (lat, lon) in rally.items():
            points[at] = _degrees(lat), _degrees(lon), points[at][2]
        return replace(self, entries=tuple(entries), rally=tuple(points))

    def inserted(self, at: int, items: Sequence[MissionItem]) -> Draft:
        """Return it with new items before the entry of an index."""
        new = [
            Entry(
                replace(
                    item,
                    lat=_degrees(item.lat or 0.0),
                    lon=_degrees(item.lon or 0.0),
                    alt_m=_tidy(item.alt_m or 0.0),
                )
            )
            for item in items
        ]
        return replace(self, entries=(*self.entries[:at], *new, *self.entries[at:]))

    def removed(self, at: int) -> Draft:
        """Return it without the entry of an index."""
        return replace(self, entries=(*self.entries[:at], *self.entries[at + 1 :]))

    def restored(self, at: int) -> Draft:
        """Return it with the entry of an index as in the source; a new item is removed."""
        place = self.entries[at].place
        if place is None:
            return self.removed(at)
        entry = replace(self.entries[at], item=self.source.items[place])
        return replace(self, entries=(*self.entries[:at], entry, *self.entries[at + 1 :]))


def _renumbered(item: MissionItem, number: int, targets: Mapping[int, int]) -> MissionItem:
    params = item.params
    if item.command == Command.DO_JUMP and params[0] is not None:
        params = (float(targets.get(int(params[0]), int(params[0]))), *params[1:])
    return replace(item, number=number, params=params)


def _stated(item: MissionItem) -> MissionItem:
    """Return an item without its number and its target."""
    params = item.params if item.command in CIRCLES else (None,) * 4
    return replace(item, number=0, params=params)


def _degrees(value: float) -> float:
    return round(float(value), DEGREE_DECIMALS)


def _tidy(height_m: float) -> float:
    """Return a height in whole millimetres."""
    return round(float(height_m), 3)
