"""The mission that the values of a problem file, or parsed arguments, describe."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pathgene.host.errors import InputError
from pathgene.host.formats.classes import forbidding
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.mission.problem_file import read_problem
from pathgene.host.options.kinds import moment_of
from pathgene.host.options.table import FALLBACKS, OWN, RULES, SEARCH, ZONE_READING
from pathgene.host.planners import PLANNERS, named_or_default
from pathgene.host.problem.active_times import LONGEST_S
from pathgene.host.problem.aircraft import DEFAULT, Aircraft
from pathgene.host.problem.aircraft import load as load_aircraft
from pathgene.host.problem.ends import Point, end_point, place
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.tiles import remarks_on
from pathgene.host.problem.zones import (
    Circle,
    ReadZones,
    Zone,
    ZoneOptions,
    read_zones,
    zone_from_dict,
)
from pathgene.host.remarks import Reading, Remark
from pathgene.host.terrain import Terrain, embedded, load
from pathgene.host.terrain.origin import at_origin
from pathgene.host.terrain.stated import Stated


if TYPE_CHECKING:
    from pathgene.host.planning import Search

__all__ = [
    "aircraft_of",
    "end_of",
    "load_problem",
    "mission_of",
    "options_for_flight",
    "placed_at",
    "planner_of",
    "read_zones_of",
    "rules_of",
    "search_of",
    "stated_of",
    "terrain_of",
    "via_of",
    "zone_choices_of",
    "zone_options_of",
    "zones_of",
]

Values = Mapping[str, Any]

# Pressures at sea level that the weather has had, hPa, with some room.
_PRESSURES_HPA = (850.0, 1100.0)
# Length of a leg at most, in diagonals of the map.
_DETOUR = 20


def load_problem(file: str | Path) -> MissionProblem:
    """Return the mission of a problem file; it has one leg without via points and a return.

    The file's planner and output are ignored.

    Raises
    ------
    InputError
        If the file is not a problem file, or does not describe a mission.
    """
    if not isinstance(file, str | Path):
        raise InputError(f"The problem file must be the path of a file, not {file!r}.")
    return mission_of(read_problem(Path(file)))


def mission_of(
    values: Values,
    terrain: Terrain | None = None,
    *,
    say: Callable[[Reading, Reading], None] | None = None,
) -> MissionProblem:
    """Return the mission; it has one leg without via points and a return.

    Parameters
    ----------
    values : mapping
        Values by the names in :data:`pathgene.host.options.table.OPTIONS`; None stands for the
        default.
    terrain : Terrain, optional
        The terrain of the values, if it is loaded already.
    say : callable, optional
        Gets the reports on the terrain and on the zones as soon as they are read, because they may
        be the reason for a refusal that follows.

    Raises
    ------
    InputError
        If a value is bad or missing.
    """
    aircraft = aircraft_of(values)
    terrain = terrain_of(values) if terrain is None else terrain
    if values.get("as_paper"):
        terrain = terrain.on_paper
    reports = [Reading()]
    try:
        start, goal = (_needed(values, name, terrain) for name in ("start", "goal"))
        read = read_zones_of(values, terrain, reports)
    finally:
        if say is not None:
            say(terrain.reading, reports[-1])
    problem = Problem(
        terrain,
        start,
        goal,
        aircraft,
        read.zones,
        values.get("wind") or (0.0, 0.0),
        values.get("ds"),
        agl=bool(values.get("agl")),
        zones_reading=read.reading,
        **rules_of(values),
    )
    return MissionProblem(problem, via_of(values, terrain), bool(values.get("return_to_start")))


def search_of(values: Values) -> Search:
    """Return the planner with its options; options that a named planner does not have are left out.

    Raises
    ------
    InputError
        If there is no such planner, or a value is bad; also as :func:`planner_of`.
    """
    # Loads the boards, which a check does without.
    from pathgene.host.planning import Search

    planner = planner_of(values)
    having = PLANNERS[planner].options if planner in PLANNERS else ()
    return Search(
        planner,
        **{option.field: values.get(name) for name, option in SEARCH.items()},
        seed=values.get("seed") or 0,
        fallback=values.get("fallback") or FALLBACKS[0],
        **{name: values[name] for name in having if values.get(name) is not None},
    )


def planner_of(values: Values) -> str:
    """Return the planner that is named, or the default one for the board and the options.

    Raises
    ------
    InputError, JobError
        As :func:`pathgene.host.planners.registry.named_or_default`.
    """
    own = {name: values.get(name) for name in OWN}
    return named_or_default(values.get("planner"), own)


def terrain_of(values: Values) -> Terrain:
    """Load the terrain.

    Raises
    ------
    InputError
        If no terrain is given, or it cannot be loaded.
    """
    if values.get("terrain") is None:
        known = ", ".join(embedded.names())
        raise InputError(f"The terrain is missing; give --terrain ({known} or a file).")
    terrain = load(
        values["terrain"],
        cell=values.get("cell"),
        fill_voids=bool(values.get("fill_voids")),
        # No keys are read from a problem file, because it may come from anybody.
        max_cells=values.get("max_cells"),
        self_contained=bool(values.get("self_contained")),
        stated=stated_of(values),
    )
    terrain = placed_at(values, terrain)
    return terrain.on_paper if values.get("as_paper") else terrain


def stated_of(values: Values) -> Stated:
    """Return the statements on the heights of the terrain.

    Raises
    ------
    InputError
        If a value is bad.
    """
    return Stated.of(values)


def placed_at(values: Values, terrain: Terrain) -> Terrain:
    """Return the terrain with its south-west node at ``origin``, if that is given.

    Raises
    ------
    InputError
        If the origin is bad, or the terrain has a place already.
    """
    origin = values.get("origin")
    return terrain if origin is None else at_origin(terrain, *origin)


def aircraft_of(values: Values) -> Aircraft:
    """Return the aircraft: a shipped one, or one from a file or a table.

    Raises
    ------
    InputError
        If it is bad.
    """
    uav = values.get("uav")
    if isinstance(uav, Mapping):
        return Aircraft.from_dict(dict(uav), "[aircraft]")
    return load_aircraft(DEFAULT if uav is None else uav)


def zones_of(values: Values, terrain: Terrain) -> tuple[Zone, ...]:
    """Return the no-fly zones of files, tables and circles.

    Raises
    ------
    InputError
        If one is bad.
    """
    return read_zones_of(values, terrain).zones


def read_zones_of(
    values: Values, terrain: Terrain, reports: list[Reading] | None = None
) -> ReadZones:
    """Return the no-fly zones of files, tables and circles, and the report on them.

    Parameters
    ----------
    values : mapping
        Also ``zones_read``: names of files that the tables were read from, with the reports on
        them.
    reports : list of Reading, optional
        Gets the report after each file, because the next may be refused, and at the end.

    Raises
    ------
    InputError
        If one is bad.
    """
    options = zone_options_of(values)
    if any(values.get(name) for name in ("nofly", "zones", "nofly_circle")):
        options = _for_flight(options, values, terrain)
    earlier: Sequence[tuple[str, Reading]] = values.get("zones_read") or ()
    choices = {
        option.name: values[option.name] for option in ZONE_READING if values.get(option.name)
    }
    files: list[tuple[str, ReadZones]] = []
    zones: list[Zone] = []
    own: list[tuple[int, Zone]] = []

    def report(more: Iterable[Remark]) -> Reading:
        readings = [*earlier, *((file, each.reading) for file, each in files)]
        facts: dict[str, Any] = {"files": [{"file": name, **own.facts} for name, own in readings]}
        remarks = [remark for _, own in readings for remark in own.remarks]
        made = Reading(facts | ({"options": choices} if choices else {}), (*remarks, *more))
        if reports is not None:
            reports.append(made)
        return made

    def read(file: str) -> None:
        files.append((str(file), read_zones(file, terrain, options)))
        zones.extend(files[-1][1].zones)
        report(())

    for file in values.get("nofly") or ():
        read(file)
    for table in values.get("zones") or ():
        if "file" in table:
            read(table["file"])
            continue
        shape = dict(table)
        if "circle" in shape:
            shape["x"], shape["y"], shape["radius_m"] = shape.pop("circle")
        zones.append(zone_from_dict(shape))
        own.append((len(zones), zones[-1]))
    for circle in values.get("nofly_circle") or ():
        zones.append(Circle(*circle))
        own.append((len(zones), zones[-1]))
    # The evaluation of the papers knows neither heights nor times.
    powerless = () if values.get("as_paper") else remarks_on(own, terrain, options)
    left_out = tuple(part for _, each in files for part in each.left_out)
    return ReadZones(tuple(zones), left_out, report(powerless))


def zone_options_of(values: Values) -> ZoneOptions:
    """Return the choices on how zones are read.

    Raises
    ------
    InputError
        If one is bad.
    """
    forbid, qnh_hpa = values.get("forbid"), values.get("qnh")
    departure = values.get("departure")
    if qnh_hpa is not None and not _PRESSURES_HPA[0] <= qnh_hpa <= _PRESSURES_HPA[1]:
        raise InputError(
            f"The pressure at sea level must be {_PRESSURES_HPA[0]:g} to {_PRESSURES_HPA[1]:g} "
            f"hPa, not {qnh_hpa:g} (--qnh)."
        )
    return ZoneOptions(
        skip_bad=bool(values.get("skip_bad_zones")),
        forbid=None if forbid is None else forbidding(forbid),
        departure=None if departure is None else moment_of(departure),
        qnh_hpa=qnh_hpa,
    )


def zone_choices_of(reading: Reading) -> Values:
    """Return the options with which the files of zones were read, by name, from their report.

    Raises
    ------
    InputError
        If one has a bad value: the report may be of a file.
    """
    stated = reading.facts.get("options", {})
    try:
        return {
            option.name: option.kind.read(stated[option.name], Path())
            for option in ZONE_READING
            if option.name in stated
        }
    except (TypeError, ValueError):
        raise InputError(
            "The options of read.zones in the summary must be a table of the options that zones "
            "are read with."
        ) from None


def _for_flight(options: ZoneOptions, values: Values, terrain: Terrain) -> ZoneOptions:
    """Return the choices with the ceiling and the longest time of a flight over a terrain."""
    aircraft = aircraft_of(values)
    points = len(values.get("via") or values.get("via_geo") or ())
    legs = points + 1 + bool(values.get("return_to_start"))
    wind = values.get("wind") or (0.0, 0.0)
    return options_for_flight(options, terrain, aircraft, values.get("ceiling"), wind, legs)


def options_for_flight(
    options: ZoneOptions,
    terrain: Terrain,
    aircraft: Aircraft,
    ceiling_m: float | None,
    wind: tuple[float, float],
    legs: int = 1,
) -> ZoneOptions:
    """Return the choices with the ceiling and the longest time of a flight."""
    ceilings = (ceiling_m, aircraft.service_ceiling_m)
    return replace(
        options,
        ceiling_m=min((each for each in ceilings if each is not None), default=None),
        longest_s=_longest_s(terrain, aircraft, wind, legs),
    )


def _longest_s(terrain: Terrain, aircraft: Aircraft, wind: tuple[float, float], legs: int) -> float:
    """Return a time that no path over the terrain takes."""
    slowest_m_s = aircraft.cruise_speed_m_s - math.hypot(*wind)
    if slowest_m_s <= 0:
        return LONGEST_S
    across_m = math.hypot(terrain.width_m, terrain.height_m)
    return min(_DETOUR * legs * across_m / slowest_m_s, LONGEST_S)


def end_of(values: Values, name: str, terrain: Terrain) -> Point | None:
    """Return ``start`` or ``goal`` in local metres, with the altitude as given; None if not set."""
    local: Point | None = values.get(name)
    if local is not None:
        return local
    geographic = values.get(f"{name}_geo")
    if geographic is None:
        return None
    latitude, longitude, altitude = geographic
    return (*place(name, latitude, longitude, terrain), altitude)


def via_of(values: Values, terrain: Terrain) -> tuple[Point, ...]:
    """Return the via points as x, y and altitude.

    Raises
    ------
    InputError
        If they mix metres with degrees, or one is bad.
    """
    local, geographic = values.get("via") or (), values.get("via_geo") or ()
    if local and geographic:
        raise InputError("Give all via points by --via, or all by --via-geo.")
    return tuple(
        end_point(
            f"via point {number}",
            point,
            terrain,
            agl=bool(values.get("agl")),
            geo=bool(geographic),
        )
        for number, point in enumerate(local or geographic, start=1)
    )


def rules_of(values: Values) -> dict[str, Any]:
    """Return the keywords of :class:`Problem` for the rules and headings.

    Raises
    ------
    InputError
        If a rule is out of range, or is given together with ``as_paper``.
    """
    given = {name: values[name] for name in RULES if values.get(name) is not None}
    if values.get("as_paper"):
        if given:
            option = next(iter(given)).replace("_", "-")
            raise InputError(
                f"--as-paper has no rules; leave out one of --as-paper and --{option}."
            )
        return {"as_paper": True}
    fields = {
        table: {
            option.field: option.to_field(given[name])
            for name, option in RULES.items()
            if name in given and option.table == table
        }
        for table in ("rules", "mission")
    }
    return {"rules": Rules(**fields["rules"]), **fields["mission"]}


def _needed(values: Values, name: str, terrain: Terrain) -> Point:
    point = end_of(values, name, terrain)
    if point is None:
        raise InputError(f"The {name} is missing; give --{name} or --{name}-geo.")
    return point
