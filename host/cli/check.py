"""``pathgene check``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pathgene.host.cli.arguments import Commands, add_command, complete_by_file
from pathgene.host.cli.check_mission import (
    add_mission_options,
    path_faults,
    print_lines,
    run_mission,
)
from pathgene.host.cli.output import (
    note_compiling,
    note_readings,
    note_start,
    print_json,
    print_pairs,
    term_pairs,
)
from pathgene.host.cli.values import complete_options
from pathgene.host.errors import InputError, JobError
from pathgene.host.files.output import reading
from pathgene.host.formats.registry import mission_files, read_mission, read_path
from pathgene.host.options.kinds import PATH
from pathgene.host.options.table import RULES
from pathgene.host.remarks import Reading


if TYPE_CHECKING:
    from pathgene.host.problem.aircraft import Aircraft
    from pathgene.host.problem.ends import Point
    from pathgene.host.problem.problem import Problem
    from pathgene.host.problem.zones import Zone
    from pathgene.host.terrain import Terrain


__all__ = ["add", "run"]

# Start and goal from options may differ from those in the file by the rounding of the file.
_SAME_END_M = 0.01


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "check",
        run,
        "Evaluate a given path",
        "pathgene check --terrain tile.tif --path out/path.geojson --json",
        usage="[PROBLEM.toml] --path FILE [OPTIONS]",
        notes="The exit status is 0 for a feasible path, 1 for one that is not, 2 for bad input.",
    )
    parser.add_argument(
        "--path",
        metavar="FILE",
        required=True,
        help="GeoJSON, CSV with the header x,y,z, or a summary.json, which also supplies the "
        f"options that are not given; or a mission of any ground station: {mission_files()}",
    )
    add_mission_options(parser)
    group = parser.add_argument_group("output")
    group.add_argument(
        "--out",
        type=PATH.parse,
        metavar="DIR",
        help="directory to write check.json of a mission to, and check.png, the picture that marks "
        "its faults by their numbers (default: no files, whatever the problem file says)",
    )
    group.add_argument(
        "--write",
        choices=("html",),
        help="also write check.html, a page that shows the faults in any browser",
    )
    complete_by_file(parser, besides=("path", "out", "write"))


def run(args: argparse.Namespace) -> int:
    """Evaluate the path and print its terms.

    A path that is not feasible, or misses a via point, is a failure.
    """
    note_start("Reading the problem.")
    from pathgene.host.checking import check
    from pathgene.host.mission.build import placed_at, rules_of, stated_of, terrain_of
    from pathgene.host.report.read import (
        find_summary,
        problem_of_path,
        summary_path,
        summary_rules,
        summary_terrain,
        summary_terrain_reading,
        summary_wind_and_step,
    )
    from pathgene.host.report.run_files import verify

    told = "as_paper" in vars(args)
    complete_options(args)
    file = Path(args.path)
    # Before asking for anything that a summary states.
    with reading("path", file):
        mission = read_mission(file)
    if mission is not None:
        return run_mission(args, file, mission)
    if args.out is not None:
        raise InputError(
            f"{file} is a path, whose picture pathgene plan draws; leave out --out, or give a "
            f"mission: {mission_files()}."
        )
    summary = find_summary(file)
    if summary is not None:
        verify(file, summary)
        wind, ds_m = summary_wind_and_step(file, summary)
        args.wind, args.ds = args.wind or wind, ds_m if args.ds is None else args.ds
        _take_rules(args, summary_rules(file, summary), told=told)
        terrain = summary_terrain(
            file,
            summary,
            args.terrain,
            cell=args.cell,
            fill_voids=args.fill_voids,
            max_cells=args.max_cells,
            stated_by_user=stated_of(vars(args)),
        )
        terrain = placed_at(vars(args), terrain)
        # The grid of a run has only heights; the summary knows the file that they came from.
        if terrain.reading.facts.get("is_own") and args.terrain is None:
            read = summary_terrain_reading(file, summary)
            terrain = terrain if read is None else terrain.having(reading=read)
        path = summary_path(file, summary)
    else:
        terrain = terrain_of(vars(args))
        path = read_path(file, terrain)
    reports = [Reading()]
    try:
        zones = _zones(args, summary, terrain, reports)
    finally:
        # They may name the cause of a refusal.
        note_readings((terrain.on_paper if args.as_paper else terrain).reading, reports[-1])
    problem = problem_of_path(
        terrain,
        path,
        _between(args, summary, terrain),
        aircraft=_aircraft(args, summary),
        zones=zones,
        zones_reading=reports[-1],
        wind=args.wind or (0.0, 0.0),
        ds_m=args.ds,
        **rules_of(vars(args)),
    )
    _check_ends(args, problem)

    note_compiling(as_paper=problem.as_paper)
    checked = check(problem, path)
    report = checked.report
    faults = None if summary is not None or problem.rules is None else path_faults(problem, path)
    if args.json:
        print_json(report if faults is None else {**report, "faults": faults.tables})
    else:
        print_pairs(term_pairs(report))
        if faults is not None:
            print_lines(faults.lines)
    broken = [visit.sentence for visit in checked.visits if visit.missed]
    if not report["feasible"]:
        broken.insert(0, "The path is not feasible; the report shows its distances and limits.")
    if broken:
        raise JobError(" ".join(broken))
    return 0


def _take_rules(args: argparse.Namespace, stated: dict[str, Any], *, told: bool) -> None:
    """Take the rules that no option gives from the summary, as keywords of a problem.

    A summary without rules sets ``as_paper``, unless that option is in ``told`` or another option
    gives a rule.
    """
    given = {name for name in RULES if getattr(args, name) is not None}
    if args.as_paper:
        return
    if "rules" not in stated:
        args.as_paper = not (told or given)
        return
    values = {**stated, **stated["rules"].to_dict()}
    for name, option in RULES.items():
        if name not in given and values[option.field] is not None:
            setattr(args, name, option.of_field(values[option.field]))


def _between(
    args: argparse.Namespace, summary: dict[str, Any] | None, terrain: Terrain
) -> tuple[Point, ...]:
    """Return the points of a mission between its start and its end."""
    from pathgene.host.mission.build import end_of, via_of
    from pathgene.host.problem.ends import end_point
    from pathgene.host.report.read import summary_way

    via = via_of(vars(args), terrain)
    if args.return_to_start:
        goal = end_of(vars(args), "goal", terrain)
        if goal is None:
            raise InputError("The goal is missing, where the path turns back; give --goal.")
        return (*via, end_point("goal", goal, terrain, agl=args.agl))
    if via or summary is None:
        return via
    return summary_way(Path(args.path), summary)


def _aircraft(args: argparse.Namespace, summary: dict[str, Any] | None) -> Aircraft:
    """Return the aircraft from ``--uav``, or from the summary, or the default."""
    from pathgene.host.mission.build import aircraft_of
    from pathgene.host.report.read import summary_aircraft

    if args.uav is None and summary is not None:
        stated = summary_aircraft(Path(args.path), summary)
        if stated is not None:
            return stated
    return aircraft_of(vars(args))


def _zones(
    args: argparse.Namespace,
    summary: dict[str, Any] | None,
    terrain: Terrain,
    reports: list[Reading],
) -> tuple[Zone, ...]:
    """Return the zones from the options, or the summary's zones if no option gives one.

    ``reports`` gets the report after each file, and at the end.
    """
    from pathgene.host.mission.build import read_zones_of
    from pathgene.host.report.read import summary_zones, summary_zones_reading

    given = read_zones_of(vars(args), terrain, reports)
    if given.zones or summary is None:
        return given.zones
    file = Path(args.path)
    # Files without a zone on the map are still named.
    reports.append(summary_zones_reading(file, summary).adding(given.reading.remarks))
    return summary_zones(file, summary)


def _check_ends(args: argparse.Namespace, problem: Problem) -> None:
    """Refuse a start or goal that differs from the path's end."""
    import numpy as np

    from pathgene.host.mission.build import end_of

    for name in ("start",) if args.return_to_start else ("start", "goal"):
        given = end_of(vars(args), name, problem.terrain)
        if given is None:
            continue
        own = getattr(problem, name)
        if args.agl:
            x, y, height_m = given
            given = x, y, problem.terrain.ground(x, y) + height_m
        if not np.allclose(given, own, rtol=0, atol=_SAME_END_M):
            raise InputError(f"The {name} of the path is {own}, not {given}; leave --{name} out.")
