"""Scenarios: events of a flight, with their times.

A scenario file is TOML: a table ``[[event]]`` for each event with ``at_s``, the seconds since the
start of the path was passed, and one or more of

- ``appear``: a list of zones, each as in ``summary.json``, or a circle that is placed when it
  appears: ``{on = "path", ahead_m = 800, radius_m = 150}``, ``{on = "goal", radius_m = 200}`` or
  ``{on = "aircraft", radius_m = 100}``. A zone may have a ``name``, and a ``velocity = [vx, vy]``,
  m/s, with which it drifts from then on.
- ``gone``: a list of names of zones that go;
- ``goal``: a new goal, x, y and altitude; ``wind``: a new wind, m/s towards true east
  and true north;
- ``board = "lost"``: the board no longer answers.

``autopilot = "finishes-leg"`` at the top describes an autopilot that accepts a new path only at the
end of its current straight or turn.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.files.output import reading
from pathgene.host.inputs import parse_toml, read_text
from pathgene.host.numeric import is_number, numbers, parse
from pathgene.host.problem.ends import Point
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import (
    Circle,
    ReadZones,
    Zone,
    ZoneOptions,
    read_zones,
    zone_from_dict,
)
from pathgene.host.remarks import Reading
from pathgene.host.terrain import Terrain


__all__ = [
    "AUTOPILOTS",
    "Event",
    "NewZone",
    "Placed",
    "Scenario",
    "check_mission",
    "named_zones",
    "parse_popup",
    "read_scenario",
]

_DEFAULTS = ZoneOptions()
#: When an autopilot accepts a new path.
AUTOPILOTS = ("at-once", "finishes-leg")
#: Where a circle may be placed.
_PLACES = ("path", "goal", "aircraft")
_EVENT = ("at_s", "appear", "gone", "goal", "wind", "board")
_OWN = ("name", "velocity")
# Names in a sentence.
_NAMES = 3


@dataclass(frozen=True)
class Placed:
    """A circle whose place is determined when it appears.

    Parameters
    ----------
    on : str
        ``path``, ``goal`` or ``aircraft``.
    radius_m : float
        Above 0.
    ahead_m : float
        For ``path``: metres ahead of the aircraft.
    """

    on: str
    radius_m: float
    ahead_m: float = 0.0


@dataclass(frozen=True)
class NewZone:
    """A zone that appears.

    Parameters
    ----------
    name : str
        Name that a later event uses; may be empty.
    velocity : (float, float)
        Its drift, m/s.
    """

    shape: Zone | Placed
    name: str = ""
    velocity: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Event:
    """An event with its time; see the module.

    Parameters
    ----------
    reading : Reading, optional
        The report on the file that its zones were read from.
    """

    at_s: float
    appear: tuple[NewZone, ...] = ()
    gone: tuple[str, ...] = ()
    goal: Point | None = None
    wind: tuple[float, float] | None = None
    board_lost: bool = False
    reading: Reading | None = field(default=None, compare=False)

    @property
    def what(self) -> str:
        """Description of the event."""
        names = [new.name or getattr(new.shape, "name", "") for new in self.appear]
        words = (
            (self.board_lost, "the board is lost"),
            (names, f"{named_zones(names)} {'appears' if len({*names}) == 1 else 'appear'}"),
            (self.gone, f"{named_zones(self.gone)} {'is' if len(self.gone) == 1 else 'are'} gone"),
            (self.goal is not None, "the goal is another"),
            (self.wind is not None, "the wind turns"),
        )
        return " and ".join(word for holds, word in words if holds)


def named_zones(names: Sequence[str]) -> str:
    """Return the zones with some names in words; those without a name are counted."""
    known = list(dict.fromkeys(filter(None, names)))
    if not known or not all(names):
        return "a zone" if len(names) == 1 else f"{len(names)} zones"
    if len(known) == 1:
        return f"zone {known[0]}"
    more = [f"{len(known) - _NAMES} more"] if len(known) > _NAMES else []
    *first, last = [*known[:_NAMES], *more]
    return f"zones {', '.join(first)} and {last}"


@dataclass(frozen=True)
class Scenario:
    """The events of a flight, in order of time.

    Parameters
    ----------
    events : tuple of Event
        In any order.
    autopilot : str
        One of :data:`AUTOPILOTS`.
    """

    events: tuple[Event, ...] = ()
    autopilot: str = AUTOPILOTS[0]
    source: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        if self.autopilot not in AUTOPILOTS:
            raise InputError(
                f"The autopilot must be {' or '.join(AUTOPILOTS)}, not {self.autopilot!r}."
            )
        object.__setattr__(self, "events", tuple(sorted(self.events, key=lambda event: event.at_s)))

    @property
    def readings(self) -> tuple[Reading, ...]:
        """The reports on the files that zones were read from."""
        return tuple(event.reading for event in self.events if event.reading is not None)

    def __add__(self, other: Scenario) -> Scenario:
        return Scenario((*self.events, *other.events), self.autopilot, self.source or other.source)


def read_scenario(file: str | Path) -> Scenario:
    """Read a scenario file.

    Raises
    ------
    InputError
        If it cannot be read, or a key or a value is not one of the above.
    """
    try:
        with reading("scenario", Path(file)):
            table = parse_toml(read_text(Path(file)))
    except UnicodeDecodeError:
        raise InputError(f"{file}: not a scenario, it is not UTF-8 text.") from None
    except ValueError as error:
        raise InputError(f"{file}: not valid TOML: {error}.") from None
    try:
        _no_others(table, ("event", "autopilot"), "a scenario")
        events = table.get("event", [])
        if not isinstance(events, list) or not events:
            raise InputError("a scenario needs a table [[event]] at least.")
        return Scenario(
            tuple(_event(each) for each in events),
            table.get("autopilot", AUTOPILOTS[0]),
            str(file),
        )
    except InputError as error:
        raise InputError(f"{file}: {error}") from None


def check_mission(mission: Problem, scenario: Scenario) -> None:
    """Refuse a mission that cannot be replanned, and impossible goals or winds.

    Raises
    ------
    InputError
        If the problem is ``as_paper`` or has via points, or a goal or a wind is bad.
    """
    if mission.rules is None:
        raise InputError(
            "Replanning in flight needs headings, which the evaluation of the papers does not "
            "know; plan without --as-paper."
        )
    if len(mission.way) > 2:
        raise InputError(
            "Replanning in flight takes plans from a start to a goal, not missions with via "
            "points; plan one leg."
        )
    for event in scenario.events:
        # Refused before the flight, not during it.
        dataclasses.replace(
            mission,
            zones=(),
            goal=event.goal or mission.goal,
            wind=event.wind or mission.wind,
            goal_heading_deg=None,
        )


def parse_popup(text: str, terrain: Terrain, options: ZoneOptions = _DEFAULTS) -> Event:
    """Return the event of ``--popup ZONE@T``.

    ZONE is ``X,Y,R``, ``ahead:M,R``, ``goal:R``, ``aircraft:R``, or a file of zones, which is read
    with ``options``.

    Raises
    ------
    InputError
        If it is not one of these.
    """
    shape, at, seconds = text.rpartition("@")
    try:
        time_s = parse(seconds)
        if not shape or not at or time_s < 0:
            raise ValueError
    except ValueError:
        raise InputError(
            f"--popup must be ZONE@T, T in seconds, as in 3000,2500,200@40, not {text!r}."
        ) from None
    kind, colon, rest = shape.partition(":")
    try:
        if colon and kind == "ahead":
            ahead, radius = map(parse, rest.split(","))
            return Event(time_s, (NewZone(_placed("path", radius, ahead)),))
        if colon and kind in ("goal", "aircraft"):
            return Event(time_s, (NewZone(_placed(kind, parse(rest))),))
        parts = shape.split(",")
        if len(parts) == 3:
            x, y, radius = map(parse, parts)
            return Event(time_s, (NewZone(Circle(x, y, radius)),))
    except InputError as error:
        raise InputError(f"--popup {text!r}: {error}") from None
    except ValueError:
        pass
    else:
        if Path(shape).exists():
            read = _zones_in(shape, terrain, options)
            facts = {"files": [{"file": shape, **read.reading.facts}]}
            reading = Reading(facts, read.reading.remarks)
            return Event(time_s, tuple(map(NewZone, read.zones)), reading=reading)
    raise InputError(
        f"The zone of --popup must be X,Y,R, ahead:M,R, goal:R, aircraft:R or a file of zones, not "
        f"{shape!r}."
    )


def _zones_in(file: str, terrain: Terrain, options: ZoneOptions) -> ReadZones:
    read = read_zones(file, terrain, options)
    if not read.reading.facts["can_forbid"]:
        why = " ".join(remark.text for remark in read.reading.remarks)
        raise InputError(f"No zone of --popup {file!r} is on the map and forbids flight. {why}")
    return read


def _event(table: Any) -> Event:
    if not isinstance(table, dict):
        raise InputError(f"an event must be a table, not {table!r}.")
    _no_others(table, _EVENT, "an event")
    at_s = table.get("at_s")
    if at_s is None or not is_number(at_s) or not at_s >= 0:
        raise InputError(f"an event needs at_s, seconds from the start, not {at_s!r}.")
    if len(table) == 1:
        raise InputError(f"the event at {at_s:g} s says nothing; give one of {_named(_EVENT[1:])}.")
    board = table.get("board")
    if board not in (None, "lost"):
        raise InputError(f'board can only be "lost", not {board!r}.')
    goal, wind = (
        None if table.get(key) is None else _numbers(key, table[key], count)
        for key, count in (("goal", 3), ("wind", 2))
    )
    # The number of coordinates is checked above, but the types do not show it.
    return Event(
        float(at_s),
        tuple(_new_zone(zone) for zone in _list("appear", table.get("appear", []))),
        tuple(_name(name) for name in _list("gone", table.get("gone", []))),
        goal,  # type: ignore[arg-type]
        wind,  # type: ignore[arg-type]
        board == "lost",
    )


def _new_zone(table: Any) -> NewZone:
    if not isinstance(table, dict):
        raise InputError(f"a zone that appears must be a table, not {table!r}.")
    name = _name(table.get("name", ""))
    east, north = _numbers("velocity", table.get("velocity", (0.0, 0.0)), 2)
    if "on" in table:
        _no_others(table, (*_OWN, "on", "ahead_m", "radius_m"), "a placed zone")
        shape: Zone | Placed = _placed(
            table["on"], table.get("radius_m"), table.get("ahead_m", 0.0)
        )
    else:
        shape = zone_from_dict({key: table[key] for key in table if key != "velocity"})
    return NewZone(shape, name, (east, north))


def _placed(on: Any, radius_m: Any, ahead_m: Any = 0.0) -> Placed:
    if on not in _PLACES:
        raise InputError(f"a zone can be placed on {_named(_PLACES)}, not on {on!r}.")
    if not is_number(radius_m) or not float(radius_m) > 0:
        raise InputError(f"the radius of a placed zone must be above 0 m, not {radius_m!r}.")
    if not is_number(ahead_m):
        raise InputError(f"ahead_m must be a number of metres, not {ahead_m!r}.")
    return Placed(on, float(radius_m), float(ahead_m))


def _numbers(key: str, value: Any, count: int) -> tuple[float, ...]:
    try:
        return numbers(value, count)
    except ValueError:
        raise InputError(f"{key} must be {count} numbers, not {value!r}.") from None


def _list(key: str, value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise InputError(f"{key} must be a list, not {value!r}.")
    return value


def _name(value: Any) -> str:
    if not isinstance(value, str):
        raise InputError(f"the name of a zone must be a text, not {value!r}.")
    return value


def _no_others(table: Mapping[str, Any], known: Sequence[str], what: str) -> None:
    for key in table:
        if key not in known:
            raise InputError(f"{what} has no key {key!r}; it takes {_named(known)}.")


def _named(words: Sequence[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}"
