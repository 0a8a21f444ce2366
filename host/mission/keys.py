"""The keys of a problem file: one table for reading, writing, the template and the docs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pathgene.host.formats.registry import extra_names, zone_files
from pathgene.host.mission.values import (
    BOOLEAN,
    CELL,
    INTEGER,
    NUMBER,
    PATH,
    POINT,
    POINTS,
    RING,
    RINGS,
    TERRAIN,
    TEXT,
    Kind,
    choice,
    vector,
)
from pathgene.host.planners import OPTIONS, PLANNERS


__all__ = ["KEYS", "RULES", "TABLES", "TOGETHER", "Key", "keys_of"]

#: The tables of a problem file in order, and what each holds.
TABLES: Mapping[str, str] = {
    "terrain": "The ground.",
    "mission": "Where to fly. Positions are metres east (x) and north (y) of the terrain's "
    "south-west node, altitudes metres above its datum.",
    "zones": "A no-fly zone, [[zones]] once for each: one of file, circle and polygon.",
    "aircraft": "A shipped aircraft by its name, the file of one, or one described here with the "
    "keys of docs/rules.md.",
    "rules": "Rules of a safe path.",
    "planner": "How to search. Options that the planner does not have are ignored with a note.",
    "output": "Outputs.",
}


@dataclass(frozen=True)
class Key:
    """A key of a problem file.

    Parameters
    ----------
    table : str
        The table that it stands in.
    name : str
        Its name.
    kind : Kind
        Reads and writes its value.
    meaning : str
        Its meaning and unit, without a full stop.
    default : str
        Its default in words; empty where there is none because the key is required.
    example : str
        A value in TOML.
    option : str
        The option of ``pathgene plan`` that overrides it; empty where only files have it.
    dest : str
        The name of its value among the parsed arguments; empty for a part of a zone or an aircraft.
    """

    table: str
    name: str
    kind: Kind
    meaning: str
    default: str
    example: str
    option: str = ""
    dest: str = ""


def _own() -> tuple[Key, ...]:
    """Return the keys of the options that only some planners have."""
    keys = []
    for name, option in OPTIONS.items():
        having = ", ".join(planner for planner, entry in PLANNERS.items() if name in entry.options)
        kind, example = TEXT, '"model:"'
        if option.choices:
            kind, example = choice(option.choices, option.type), f'"{option.choices[0]}"'
        elif option.type is int:
            kind, example = INTEGER, "8"
        keys.append(
            Key(
                "planner",
                name,
                kind,
                f"of {having}: {option.meaning}",
                "the planner's",
                example,
                f"--{name.replace('_', '-')}",
                name,
            )
        )
    return tuple(keys)


_RULES = (
    ("clearance", "least height above the ground, metres", "30", "30.0"),
    ("corridor", "half the width of the strip that keeps the clearance, metres", "25", "25.0"),
    ("ceiling", "highest altitude above the datum, metres", "none", "1500.0"),
    ("ceiling_agl", "greatest height above the ground, metres", "none", "400.0"),
    ("zone_margin", "distance to no-fly zones, also above and below, metres", "25", "25.0"),
    ("reserve", "share of the fuel to be left at the goal, per cent", "10", "10.0"),
)

#: Every key, in the order of the template and of the documentation.
KEYS: tuple[Key, ...] = (
    Key(
        "terrain",
        "source",
        TERRAIN,
        "GeoTIFF, .hgt, any other raster that rasterio opens, .npy, .npz, or a name of "
        "'pathgene terrain list'",
        "",
        '"canyon"',
        "--terrain",
        "terrain",
    ),
    Key(
        "terrain",
        "fill_voids",
        BOOLEAN,
        "interpolate cells without data, which no path may cross otherwise",
        "false",
        "false",
        "--fill-voids",
        "fill_voids",
    ),
    Key(
        "terrain",
        "cell",
        CELL,
        "side of a cell of a .npy terrain, or its sides east and north, metres",
        "none",
        "30.0",
        "--cell",
        "cell",
    ),
    Key(
        "terrain",
        "origin",
        vector(2),
        "WGS84 latitude and longitude of the south-west node of a terrain that states no place, "
        "north up",
        "none",
        "[36.2, -84.4]",
        "--origin",
        "origin",
    ),
    Key("mission", "start", POINT, "x, y, altitude", "", "[300, 300, 60]", "--start", "start"),
    Key(
        "mission",
        "start_geo",
        POINT,
        "instead of start: WGS84 latitude and longitude in degrees, and altitude",
        "none",
        "[36.32, -84.31, 100]",
        "--start-geo",
        "start_geo",
    ),
    Key("mission", "goal", POINT, "x, y, altitude", "", "[4700, 4600, 60]", "--goal", "goal"),
    Key(
        "mission",
        "goal_geo",
        POINT,
        "instead of goal: latitude, longitude, altitude",
        "none",
        "[36.55, -84.04, 100]",
        "--goal-geo",
        "goal_geo",
    ),
    Key(
        "mission",
        "via",
        POINTS,
        "points to pass between start and goal, in order, each x, y, altitude",
        "none",
        "[[2500, 1000, 80], [3000, 3000, 80]]",
        "--via",
        "via",
    ),
    Key(
        "mission",
        "via_geo",
        POINTS,
        "instead of via: latitude, longitude, altitude of each",
        "none",
        "[[36.40, -84.20, 100]]",
        "--via-geo",
        "via_geo",
    ),
    Key(
        "mission",
        "return",
        BOOLEAN,
        "fly back from the goal to the start, where the mission ends",
        "false",
        "false",
        "--return",
        "return_to_start",
    ),
    Key(
        "mission",
        "agl",
        BOOLEAN,
        "the altitudes of start, goal and via points are heights above the ground",
        "false",
        "true",
        "--agl",
        "agl",
    ),
    Key(
        "mission",
        "start_heading",
        NUMBER,
        "heading at the start, degrees clockwise from the frame's north",
        "any",
        "90.0",
        "--start-heading",
        "start_heading",
    ),
    Key(
        "mission",
        "goal_heading",
        NUMBER,
        "heading at the end of the mission, degrees clockwise from the frame's north",
        "any",
        "180.0",
        "--goal-heading",
        "goal_heading",
    ),
    Key(
        "mission",
        "wind",
        vector(2),
        "constant wind towards the east and towards the north, m/s",
        "[0, 0]",
        "[3.0, -2.0]",
        "--wind",
        "wind",
    ),
    Key(
        "mission",
        "ds",
        NUMBER,
        "sampling step of the evaluation, metres",
        "half the shorter side of a cell",
        "20.0",
        "--ds",
        "ds",
    ),
    Key(
        "zones",
        "file",
        PATH,
        zone_files(),
        "none",
        '"zones.geojson"',
        "--nofly",
    ),
    Key(
        "zones",
        "circle",
        vector(3),
        "x and y of the centre, and the radius, metres",
        "none",
        "[2500.0, 2500.0, 300.0]",
        "--nofly-circle",
    ),
    Key(
        "zones",
        "polygon",
        RING,
        "x and y of each corner, metres, in either direction",
        "none",
        "[[2000, 2000], [2600, 2000], [2300, 2500]]",
    ),
    Key(
        "zones",
        "holes",
        RINGS,
        "parts of the polygon that may be flown through, each a list of corners",
        "none",
        "[[[2200, 2100], [2400, 2100], [2300, 2300]]]",
    ),
    Key("zones", "name", TEXT, "name of the circle or polygon in reports", "none", '"town"'),
    Key("zones", "lower", NUMBER, "lowest altitude inside, metres", "no limit", "200.0"),
    Key("zones", "upper", NUMBER, "highest altitude inside, metres", "no limit", "900.0"),
    Key("zones", "t0", NUMBER, "active from this second of the flight on", "no limit", "60.0"),
    Key("zones", "t1", NUMBER, "active up to this second of the flight", "no limit", "300.0"),
    Key(
        "aircraft",
        "name",
        TEXT,
        "a shipped aircraft (silver-fox, c172p, j3cub, sperwer, heron, predator); with other keys "
        "beside it, the name of the aircraft that they describe",
        "silver-fox",
        '"silver-fox"',
        "--uav",
    ),
    Key("aircraft", "file", PATH, "the TOML file of an aircraft", "none", '"mine.toml"', "--uav"),
    *(
        Key(
            "rules",
            name,
            NUMBER,
            meaning,
            default,
            example,
            f"--{name.replace('_', '-')}",
            name,
        )
        for name, meaning, default, example in _RULES
    ),
    Key(
        "rules",
        "as_paper",
        BOOLEAN,
        "no rules and no headings: the evaluation of the papers alone, as in version 0.1",
        "false",
        "false",
        "--as-paper",
        "as_paper",
    ),
    Key(
        "planner",
        "name",
        choice(tuple(PLANNERS)),
        "the planner",
        "ga-chip, on a board with the paper core ga-fpga",
        '"ga-chip"',
        "--planner",
        "planner",
    ),
    Key(
        "planner",
        "generations",
        INTEGER,
        "maximum generations, of each leg",
        "the planner's",
        "300",
        "--generations",
        "generations",
    ),
    Key(
        "planner",
        "time_limit",
        NUMBER,
        "maximum planning time of each leg, seconds",
        "none",
        "60.0",
        "--time-limit",
        "time_limit",
    ),
    Key(
        "planner",
        "target_fitness",
        NUMBER,
        "stop when the best fitness reaches this",
        "none",
        "1.5",
        "--target-fitness",
        "target_fitness",
    ),
    Key(
        "planner",
        "population",
        INTEGER,
        "paths in the population",
        "the planner's",
        "32",
        "--population",
        "population",
    ),
    Key(
        "planner",
        "seed",
        INTEGER,
        "seed of all random draws; the same seed gives the same result",
        "0",
        "0",
        "--seed",
        "seed",
    ),
    Key(
        "planner",
        "fallback",
        choice(("astar", "none")),
        "astar, and then fpa-2opt, search where the planner finds no feasible path; none with "
        "as_paper",
        "astar",
        '"astar"',
        "--fallback",
        "fallback",
    ),
    *_own(),
    Key("output", "out", PATH, "directory to write to", "out", '"out"', "--out", "out"),
    Key(
        "output",
        "write",
        TEXT,
        f"also write the path for other programs: some of {extra_names()}, separated by commas",
        "none",
        '"plan,kml"',
        "--write",
        "write",
    ),
    Key(
        "output",
        "picture",
        BOOLEAN,
        "draw path.png",
        "true",
        "true",
        "--no-picture",
        "picture",
    ),
    Key(
        "output",
        "grid",
        BOOLEAN,
        "write terrain.npz, the grid that the path was evaluated on",
        "true",
        "true",
        "--no-grid",
        "grid",
    ),
)

#: Values that set a rule or a heading; ``as_paper`` excludes them.
RULES = (*(name for name, *_ in _RULES), "start_heading", "goal_heading")

#: Values of which an option on the command line replaces all that a file gives.
TOGETHER = (
    ("start", "start_geo"),
    ("goal", "goal_geo"),
    ("via", "via_geo"),
    ("nofly", "nofly_circle", "zones"),
)


def keys_of(table: str) -> dict[str, Key]:
    """Return the keys of a table by name."""
    return {key.name: key for key in KEYS if key.table == table}
