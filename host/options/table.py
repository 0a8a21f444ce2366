"""The table of options: each row makes an argument, a key of problem files, a field and docs."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from pathgene.host.formats.registry import choices, zone_files
from pathgene.host.old_words import current_engine
from pathgene.host.options.kinds import (
    BOOLEAN,
    CELL,
    CLASSES,
    GEO_POINT,
    GEO_POINTS,
    HEIGHT,
    INTEGER,
    MOMENT,
    NUMBER,
    PATH,
    POINT,
    POINTS,
    RING,
    RINGS,
    TERRAIN,
    TEXT,
    VOIDS,
    WATER_LEVEL,
    Kind,
    choice,
    vector,
)
from pathgene.host.options.option import Group, Option
from pathgene.host.planners import DEFAULT, DEFAULT_BOARD, DEFAULT_TEXT, ENGINES, PLANNERS
from pathgene.host.problem.aircraft import DEFAULT as AIRCRAFT
from pathgene.host.problem.rules import Rules


__all__ = [
    "FALLBACKS",
    "NAMED",
    "OPTIONS",
    "OWN",
    "RULES",
    "SEARCH",
    "TABLES",
    "TOGETHER",
    "ZONE_READING",
    "keys_of",
    "options_of",
]

#: Planners that may search if the named planner finds no feasible path; the default first.
FALLBACKS = ("astar", "none")

#: The tables of a problem file in order, and the contents of each.
TABLES: Mapping[str, str] = {
    "terrain": "The ground.",
    "mission": "The points to fly to. Positions are metres east (x) and north (y) of the terrain's "
    "south-west node, altitudes metres above its datum.",
    "zones": "A no-fly zone, [[zones]] once for each: one of file, circle and polygon.",
    "aircraft": "A shipped aircraft by its name, an aircraft's file, or one described here with "
    "the keys of docs/rules.md.",
    "rules": "The rules that a safe path keeps.",
    "planner": "The search. Options that the planner does not have are ignored with a note.",
    "output": "The files to write.",
}

_GENERATIONS = ", ".join(f"{name} {entry.generations}" for name, entry in PLANNERS.items())


def _rule(name: str, meaning: str, field: str, metavar: str, **more: Any) -> Option:
    """Return the row of a rule, whose default is the default of :class:`Rules`."""
    row = Option(
        name=name, kind=NUMBER, meaning=meaning, group="rules", table="rules", field=field,
        metavar=metavar, **more,
    )  # fmt: skip
    default = getattr(Rules, field)
    text = "none" if default is None else f"{row.of_field(default):g}"
    return dataclasses.replace(row, default_text=text)


def _own(name: str, kind: Kind, meaning: str, default: str, example: str, **more: Any) -> Option:
    """Return the row of an option that only some planners have; they decide its default."""
    return Option(
        name=name, kind=kind, meaning=meaning, group="own", table="planner",
        default_text=default, example=example, **more,
    )  # fmt: skip


def _zone(name: str, kind: Kind, meaning: str, default: str, example: str, **more: Any) -> Option:
    """Return the row of a key of a zone, which has no option."""
    return Option(
        name=name, kind=kind, meaning=meaning, group="file", table="zones",
        default_text=default, example=example, **more,
    )  # fmt: skip


_PROBLEM = (
    Option(name="terrain", kind=TERRAIN,
           meaning="GeoTIFF, .hgt, any other raster that rasterio opens, .npy, .npz, or a name "
                   "from 'pathgene terrain list'",
           group="problem", table="terrain", key="source", metavar="FILE|NAME", is_required=True,
           example='"canyon"', desk="map"),
    Option(name="fill_voids", kind=BOOLEAN,
           meaning="interpolate cells without data; otherwise no path may cross them",
           group="problem", table="terrain", default=False, example="false"),
    Option(name="cell", kind=CELL,
           meaning="side of a cell of a .npy terrain, or its sides east and north, metres",
           group="problem", table="terrain", example="30.0"),
    Option(name="origin", kind=vector("LAT,LON"),
           meaning="WGS84 latitude and longitude of the south-west node of a terrain that states"
                   " no place, north up",
           group="problem", table="terrain", example="[36.2, -84.4]"),
    Option(name="water_level", kind=WATER_LEVEL,
           meaning="height of the water above the datum, metres; lower ground is taken for the"
                   " bottom of the sea. Give none for land below the sea",
           group="problem", table="terrain",
           default_text="0; none for a terrain without a place on Earth", example="0.0"),
    Option(name="height_unit", kind=choice(("m", "dm", "cm", "ft", "us-ft")),
           meaning="unit of the heights in the terrain's file",
           group="problem", table="terrain",
           default_text="as the file states, else m; a plane in feet needs it", example='"ft"'),
    Option(name="heights", kind=choice(("sea-level", "ellipsoidal")),
           meaning="reference of the heights in the terrain's file; ellipsoidal accepts"
                   " altitudes above the ellipsoid where PROJ has no grid of the geoid",
           group="problem", table="terrain", default_text="as the file states, else sea-level",
           example='"sea-level"'),
    Option(name="void", kind=VOIDS,
           meaning="numbers in the terrain's file that mark voids, as in -9999,0; none takes all"
                   " numbers from -11,000 to 9,000 m as heights",
           group="problem", table="terrain",
           default_text="the declared mark, and numbers that no ground has", example="[-9999.0]"),
    # The limit belongs to the user. Problem files, which may come from anybody, have no key for it.
    Option(name="max_cells", kind=INTEGER,
           meaning="maximum cells of a terrain that is read",
           group="problem", default_text="25 million", desk="none"),
    Option(name="start", kind=POINT,
           meaning="x and y, metres east and north of the south-west node, and altitude in metres",
           group="problem", table="mission", is_required=True, example="[300, 300, 60]",
           desk="map"),
    Option(name="start_geo", kind=GEO_POINT,
           meaning="instead of start: WGS84 latitude and longitude in degrees, altitude in "
                   "metres",
           group="problem", table="mission", instead_of="start", example="[36.32, -84.31, 100]",
           desk="map"),
    Option(name="goal", kind=POINT,
           meaning="x, y and altitude",
           group="problem", table="mission", is_required=True, example="[4700, 4600, 60]",
           desk="map"),
    Option(name="goal_geo", kind=GEO_POINT,
           meaning="instead of goal: WGS84 latitude, longitude, and altitude",
           group="problem", table="mission", instead_of="goal", example="[36.55, -84.04, 100]",
           desk="map"),
    Option(name="via", kind=POINTS,
           meaning="points to pass between start and goal, in order, each x, y, altitude",
           group="problem", table="mission", default=(), is_repeated=True,
           example="[[2500, 1000, 80], [3000, 3000, 80]]", desk="map"),
    Option(name="via_geo", kind=GEO_POINTS,
           meaning="instead of via: WGS84 latitude, longitude, altitude of each point",
           group="problem", table="mission", default=(), is_repeated=True,
           example="[[36.40, -84.20, 100]]", desk="map"),
    Option(name="return_to_start", kind=BOOLEAN,
           meaning="fly back from the goal to the start, where the mission ends",
           group="problem", table="mission", key="return", flag="--return", default=False,
           example="false"),
    Option(name="agl", kind=BOOLEAN,
           meaning="altitudes of start, goal and via points are heights above the ground",
           group="problem", table="mission", default=False, example="true"),
    Option(name="start_heading", kind=NUMBER,
           meaning="heading at the start, degrees clockwise from true north",
           group="rules", table="mission", metavar="DEG", default_text="any", example="90.0",
           field="start_heading_deg"),
    Option(name="goal_heading", kind=NUMBER,
           meaning="heading at the end of the mission, degrees clockwise from true north",
           group="rules", table="mission", metavar="DEG", default_text="any", example="180.0",
           field="goal_heading_deg"),
    Option(name="wind", kind=vector("VX,VY"),
           meaning="constant wind towards true east and towards true north, m/s",
           group="problem", table="mission", default_text="0, 0", example="[3.0, -2.0]"),
    Option(name="ds", kind=NUMBER,
           meaning="sampling step of the evaluation, metres",
           group="problem", table="mission", metavar="M",
           default_text="half the shorter side of a cell", example="20.0"),
    # For all files, not for one of [[zones]].
    Option(name="skip_bad_zones", kind=BOOLEAN,
           meaning="read files of zones without their bad features, which are named",
           group="problem", table="mission", default=False, example="false"),
    Option(name="forbid", kind=CLASSES,
           meaning="classes of airspace that forbid flight, as in default,E; default and all stand "
                   "for several",
           group="problem", table="mission", metavar="LIST",
           default_text="default", example='"default,E"'),
    Option(name="departure", kind=MOMENT,
           meaning="time of the start with its time zone, as in 2026-05-01T09:00+02:00, for zones "
                   "with times of day",
           group="problem", table="mission", metavar="TIME",
           default_text="unknown: such zones are always active",
           example='"2026-05-01T09:00+02:00"'),
    Option(name="qnh", kind=NUMBER,
           meaning="pressure at sea level for flight levels of zones, hPa",
           group="problem", table="mission", metavar="HPA",
           default_text="any from 950 to 1050", example="1013.25"),
    Option(name="end", kind=choice(("loiter", "land", "rtl")),
           meaning="end of the exported mission after its goal: a circle with room, a landing "
                   "(--land) or a return to home",
           group="end", table="mission",
           default_text="loiter; land with --land; as planned for export and upload",
           example='"rtl"'),
    Option(name="land", kind=vector("X,Y,HEADING"),
           meaning="place of a landing and the heading there, degrees clockwise from true north; "
                   "the mission ends with an approach and a go-around that have room",
           group="end", table="mission", default_text="none", example="[4000.0, 4200.0, 90.0]"),
    Option(name="land_geo", kind=vector("LAT,LON,HEADING"),
           meaning="instead of land: WGS84 latitude and longitude, and the heading",
           group="end", table="mission", instead_of="land", default_text="none",
           example="[36.54, -84.05, 90.0]"),
    Option(name="nofly", kind=PATH,
           meaning=f"file of no-fly zones: {zone_files()}",
           group="problem", table="zones", key="file", metavar="FILE", default=(),
           is_repeated=True, example='"zones.geojson"', desk="map"),
    Option(name="nofly_circle", kind=vector("X,Y,R"),
           meaning="circular no-fly zone: x and y of the centre, and the radius, metres",
           group="problem", table="zones", key="circle", default=(), is_repeated=True,
           example="[2500.0, 2500.0, 300.0]", desk="map"),
)  # fmt: skip

_ZONES = (
    _zone("polygon", RING, "x and y of each corner, metres, in either direction", "none",
          "[[2000, 2000], [2600, 2000], [2300, 2500]]", desk="map"),
    _zone("holes", RINGS, "parts of the polygon that may be flown through, each a list of corners",
          "none", "[[[2200, 2100], [2400, 2100], [2300, 2300]]]", desk="map"),
    _zone("name", TEXT, "name of the circle or polygon in reports", "none", '"town"'),
    _zone("lower", HEIGHT, "minimum altitude inside, metres", "no limit", "200.0"),
    _zone("upper", HEIGHT, "maximum altitude inside, metres", "no limit", "900.0"),
    _zone("t0", NUMBER, "active from this second of the flight", "no limit", "60.0"),
    _zone("t1", NUMBER, "active up to this second of the flight", "no limit", "300.0"),
)  # fmt: skip

_AIRCRAFT = (
    Option(name="uav", kind=TEXT,
           meaning="a shipped aircraft (silver-fox, c172p, j3cub, sperwer, heron, predator), or "
                   "on the command line its .toml file; in a problem file, together with"
                   " other keys, the name of the aircraft that they describe",
           group="problem", table="aircraft", key="name", metavar="NAME|FILE",
           default_text=AIRCRAFT, example=f'"{AIRCRAFT}"'),
    Option(name="uav_file", kind=PATH,
           meaning="the TOML file of an aircraft",
           group="file", table="aircraft", key="file", flag="--uav", example='"mine.toml"'),
)  # fmt: skip

_RULES = (
    _rule("clearance", "minimum height above the ground, metres", "clearance_m", "M",
          example="30.0"),
    _rule("corridor", "half-width of the strip in which the clearance is kept, metres",
          "corridor_m", "M", example="25.0"),
    _rule("ceiling", "maximum altitude above the datum, metres", "ceiling_m", "M",
          example="1500.0"),
    _rule("ceiling_agl", "maximum height above the ground, metres", "ceiling_agl_m", "M",
          example="400.0"),
    _rule("zone_margin", "distance to no-fly zones, also above and below, metres",
          "zone_margin_m", "M", example="25.0"),
    _rule("reserve", "share of the fuel that must remain at the goal, per cent", "reserve",
          "PERCENT", percent=True, example="10.0"),
    Option(name="as_paper", kind=BOOLEAN,
           meaning="evaluate as the papers do, without rules or headings, as in version 0.1",
           group="rules", table="rules", default=False, example="false"),
)  # fmt: skip

_PLANNING = (
    Option(name="planner", kind=choice(tuple(PLANNERS)),
           meaning="the planner",
           group="planning", table="planner", key="name", metavar="NAME",
           default_text=DEFAULT_TEXT,
           example=f'"{DEFAULT}"'),
    Option(name="generations", kind=INTEGER,
           meaning="maximum generations of each leg",
           group="search", table="planner",
           default_text=_GENERATIONS,
           example="300", field="generations"),
    Option(name="time_limit", kind=NUMBER,
           meaning="maximum planning time of each leg, seconds",
           group="search", table="planner", metavar="S", example="60.0", field="time_limit_s"),
    Option(name="target_fitness", kind=NUMBER,
           meaning="stop when the best fitness reaches this value",
           group="search", table="planner", metavar="F", example="1.5", field="target_fitness"),
    Option(name="population", kind=INTEGER,
           meaning="paths in the population",
           group="search", table="planner", default_text="the planner's", example="32",
           field="population"),
    Option(name="seed", kind=INTEGER,
           meaning="seed of all random draws; the same seed gives the same result",
           group="planning", table="planner", default=0, example="0"),
    Option(name="fallback", kind=choice(FALLBACKS),
           meaning="search with astar, then fpa-2opt, if the planner finds no feasible path; "
           "ga-chip has searched with astar before",
           group="planning", table="planner", default=FALLBACKS[0],
           default_text=f"{FALLBACKS[0]}; none with --as-paper", example=f'"{FALLBACKS[0]}"'),
)  # fmt: skip

_OWN = (
    _own("board", TEXT, "model:, sim:, sim:?sim=icarus, a serial device or a URL of pyserial",
         DEFAULT_BOARD, f'"{DEFAULT_BOARD}"', metavar="URL"),
    _own("chip_ms", INTEGER, "maximum milliseconds of a plan by the chip's clock, not counting "
         "runs without a path", "none: the generations are the limit", "8", metavar="MS"),
    _own("polish", choice(("on", "chip", "off")), "give the chip's paths the lowest altitudes, on "
         "the host; on: also search with astar, begin runs along its path where two found none, "
         "and refine the best path; chip: neither; off: report the paths as they are",
         "on", '"on"'),
    _own("link_mode", choice(("rank", "population", "recipe")), "data sent over the link in each "
         "generation", "rank", '"rank"'),
    _own("feasibility", choice(("host", "board")), "side that counts the distance under the "
         "terrain during the search; the report always uses the host's count", "host",
         '"host"'),
    _own("initial_draws", INTEGER, "paths drawn for each path of the first population, which keeps "
         "the best", "4; the paper's is 1", "8"),
    _own("engine", choice(ENGINES, current_engine), "all threads, one thread, or an NVIDIA GPU; "
         "the GPU rounds differently", ENGINES[0], f'"{ENGINES[0]}"'),
    _own("waypoints", INTEGER, "free waypoints of every path", "6, with --init astar 16", "8"),
    _own("two_opt_every", INTEGER, "iterations between two applications of 2-opt; 0 for none",
         "20", "8"),
    _own("max_waypoints", INTEGER, "maximum transitional waypoints of a path",
         "20, of astar 32, of which 16 turn, or 64 where these find no path", "8"),
    _own("init", choice(("random", "astar")), "first population: random, or astar: the paths that "
         "the planner astar finds, and varied copies of them", "random", '"random"'),
    _own("refits", INTEGER, "children per generation that are the best path with one or two "
         "waypoints moved and the lowest altitudes", "2 with --init astar, else 0", "8"),
    _own("reading", choice(("route", "sum")), "cost of a route in the crossover: the cost of the "
         "whole route, or the sum of its segments' costs", "route", '"route"'),
    _own("draws", choice(("near", "uniform")), "draw crossover points and segments near the best "
         "route or, as in the paper, anywhere", "near", '"near"'),
    _own("added_points", INTEGER, "crossover points added per generation", "8", "8"),
)  # fmt: skip

_OUTPUT = (
    Option(name="out", kind=PATH,
           meaning="directory to write to",
           group="output", table="output", metavar="DIR", default="out", example='"out"',
           desk="none"),
    Option(name="write", kind=TEXT,
           meaning=f"also write files of these formats, as in plan,kml: {choices()}; "
                   "path.geojson is always written",
           group="output", table="output", metavar="LIST", default="", example='"plan,kml"',
           desk="none"),
    Option(name="fence_corners", kind=INTEGER,
           meaning="maximum corners and circles of an autopilot's fences, to which zones are"
                   " simplified outwards",
           group="output", table="output",
           default_text="64; for an ArduPilot that is known, 84", example="64", desk="none"),
    Option(name="simplify", kind=NUMBER,
           meaning="maximum distance of an autopilot's legs from legs that touch the track, metres;"
                   " 0 keeps every waypoint",
           group="output", table="output", metavar="M",
           default_text="1", example="1.0", desk="none"),
    Option(name="picture", kind=BOOLEAN,
           meaning="draw path.png; otherwise remove any left by an earlier run",
           group="output", table="output", default=True, example="true", desk="none"),
    Option(name="grid", kind=BOOLEAN,
           meaning="write terrain.npz, the grid that the path was evaluated on; otherwise remove"
                   " any left by an earlier run, and pathgene check loads the terrain from its"
                   " source",
           group="output", table="output", default=True, example="true", desk="none"),
)  # fmt: skip

#: Every option, in the order of problem files and of the documentation.
OPTIONS: tuple[Option, ...] = (
    *_PROBLEM,
    *_ZONES,
    *_AIRCRAFT,
    *_RULES,
    *_PLANNING,
    *_OWN,
    *_OUTPUT,
)


def options_of(*groups: Group) -> tuple[Option, ...]:
    """Return the options of groups, in the order of the table."""
    return tuple(option for option in OPTIONS if option.group in groups)


def keys_of(table: str) -> dict[str, Option]:
    """Return the options of a table of a problem file by their keys."""
    return {option.key: option for option in OPTIONS if option.table == table}


#: The options of the command line, by name.
NAMED: Mapping[str, Option] = {option.name: option for option in OPTIONS if option.group != "file"}
#: Options on how files of zones are read.
ZONE_READING = tuple(NAMED[name] for name in ("skip_bad_zones", "forbid", "departure", "qnh"))

#: Options that every planner has, by name: fields of :class:`pathgene.host.planners.base.Options`.
SEARCH: Mapping[str, Option] = {option.name: option for option in options_of("search")}

#: Options that only some planners have, by the keyword of their constructors.
OWN: Mapping[str, Option] = {option.name: option for option in options_of("own")}

#: Options that set a rule or a heading, by name; ``as_paper`` excludes them.
RULES: Mapping[str, Option] = {
    option.name: option
    for option in sorted(options_of("rules"), key=lambda option: option.table != "rules")
    if option.field
}

#: Groups of values: an option of a group on the command line replaces all values of it in a file.
TOGETHER = (
    *((option.instead_of, option.name) for option in OPTIONS if option.instead_of),
    ("via", "via_geo"),
    ("nofly", "nofly_circle", "zones"),
)
