"""Zones, goal and wind that change during a flight."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field

from pathgene.host.errors import InputError
from pathgene.host.problem.changes import zones_after
from pathgene.host.problem.ends import Point
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.tiles import over_ground, tiles_of
from pathgene.host.problem.zones import Circle, Zone
from pathgene.host.replanning.scenario import Event, NewZone, Placed


__all__ = ["Airspace", "Place"]

#: Period of the positions of a drifting zone, seconds.
DRIFT_S = 5.0

#: Returns x and y of a zone's place: ``path`` with metres ahead, ``goal`` or ``aircraft``.
Place = Callable[[str, float], tuple[float, float]]


@dataclass
class _Known:
    """A zone as it was given, with its tiles or itself at its current place."""

    origin: Zone
    tiles: tuple[Zone, ...]
    velocity: tuple[float, float] = (0.0, 0.0)
    since_s: float = 0.0

    @property
    def name(self) -> str:
        """Its name."""
        return self.origin.name


@dataclass
class Airspace:
    """Zones, goal and wind at the current time of a flight, and the zones of earlier times.

    Parameters
    ----------
    mission : Problem
        The problem at the beginning of the flight.

    Attributes
    ----------
    goal, wind
        The current goal and wind.
    past : list of (float, tuple of Zone)
        Times in order, each with the zones that apply from then on.
    """

    mission: Problem
    goal: Point = field(init=False)
    wind: tuple[float, float] = field(init=False)
    past: list[tuple[float, tuple[Zone, ...]]] = field(init=False)

    def __post_init__(self) -> None:
        self.goal, self.wind = self.mission.goal, self.mission.wind
        self._known = [_Known(tiles[0].whole, tiles) for tiles in tiles_of(self.mission.zones)]
        self._count = 0
        self.past = [(0.0, self._zones)]

    def happen(self, event: Event, place: Place) -> None:
        """Apply an event; ``place`` tells where a placed zone is.

        Raises
        ------
        InputError
            If a zone that is to go does not exist.
        """
        for name in event.gone:
            if not any(known.name == name for known in self._known):
                raise InputError(f"No zone of the name {name!r} is there at {event.at_s:g} s.")
            self._known = [known for known in self._known if known.name != name]
        appeared: list[_Known] = []
        for new in event.appear:
            zone = self._made(new, place, appeared)
            tiles = over_ground((zone,), self.mission.terrain, len(event.appear))
            appeared.append(_Known(zone, tiles, new.velocity, event.at_s))
        # A zone with the same name has moved; zones that appear together may share a name.
        moved = {known.name for known in appeared}
        self._known = [known for known in self._known if known.name not in moved] + appeared
        self.goal = self.goal if event.goal is None else event.goal
        self.wind = self.wind if event.wind is None else event.wind
        self._note(event.at_s)

    def drift(self, time_s: float) -> tuple[str, ...]:
        """Move the zones that drift; return their names."""
        drifting = [known for known in self._known if known.velocity != (0.0, 0.0)]
        for known in drifting:
            flown_s = time_s - known.since_s
            by = known.velocity[0] * flown_s, known.velocity[1] * flown_s
            known.tiles = over_ground((known.origin.moved(*by),), self.mission.terrain)
        if drifting:
            self._note(time_s)
        return tuple(known.name for known in drifting)

    def zones_at(self, time_s: float) -> tuple[Zone, ...]:
        """Return the current zones that are or will be active, with times counted from now."""
        return zones_after(self._zones, time_s)

    @property
    def _zones(self) -> tuple[Zone, ...]:
        return tuple(tile for known in self._known for tile in known.tiles)

    def _note(self, time_s: float) -> None:
        self.past.append((time_s, self._zones))

    def _unused_name(self, appeared: list[_Known]) -> str:
        taken = {known.name for known in (*self._known, *appeared)}
        while True:
            self._count += 1
            if (name := f"pop-up {self._count}") not in taken:
                return name

    def _made(self, new: NewZone, place: Place, appeared: list[_Known]) -> Zone:
        if isinstance(new.shape, Placed):
            x, y = place(new.shape.on, new.shape.ahead_m)
            return Circle(x, y, new.shape.radius_m, name=new.name or self._unused_name(appeared))
        name = new.name or new.shape.name or self._unused_name(appeared)
        return dataclasses.replace(new.shape, name=name)
