"""``pathgene check`` of a mission of any ground station."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pathgene.host.cli.arguments import Parser, add_problem
from pathgene.host.cli.drawing import import_quickly
from pathgene.host.cli.output import (
    note,
    note_compiling,
    note_readings,
    print_json,
    print_pairs,
)
from pathgene.host.errors import InputError, JobError
from pathgene.host.files.output import prepare_directory
from pathgene.host.options.kinds import NUMBER
from pathgene.host.remarks import Reading


if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from pathgene.host.formats.mission_items import MissionFile
    from pathgene.host.mission.foreign.check import MissionCheck
    from pathgene.host.mission.foreign.judge import FlightProblem
    from pathgene.host.problem.problem import Problem

__all__ = [
    "add_mission_options",
    "note_mission",
    "path_faults",
    "print_lines",
    "problem_of_mission",
    "run_mission",
]

# Options of a path that a mission states itself, or that have no meaning for it.
_OF_PATHS = (
    *("start", "start_geo", "goal", "goal_geo", "via", "via_geo", "return_to_start", "agl"),
    *("start_heading", "goal_heading", "as_paper"),
)


def add_mission_options(parser: Parser) -> None:
    """Add the options that judge a mission: of its problem, of the rules, and of its return."""
    add_problem(parser, of_path=True)
    parser.add_argument(
        "--return-height",
        metavar="M",
        type=NUMBER.parse,
        help="height above home at which a mission returns to launch, metres (default 100 for "
        "ArduPilot, 60 for PX4)",
    )


def problem_of_mission(
    args: argparse.Namespace, file: Path, mission: MissionFile
) -> tuple[FlightProblem, Reading]:
    """Return the problem of a mission by the options, and the report on files of zones."""
    from pathgene.host.mission.build import read_zones_of, terrain_of
    from pathgene.host.mission.foreign.conditions import flight_problem_of

    for name in _OF_PATHS:
        if getattr(args, name, None):
            option = "return" if name == "return_to_start" else name.replace("_", "-")
            raise InputError(f"{file} is a mission, which is judged without --{option}.")
    values = dict(vars(args))
    if mission.has_fences:
        values["nofly"] = [*(args.nofly or ()), str(file)]
    terrain = terrain_of(values)
    reports = [Reading()]
    try:
        zones = read_zones_of(values, terrain, reports).zones
    finally:
        # They may name the cause of a refusal.
        note_readings(terrain.reading, reports[-1])
    problem = flight_problem_of(values, terrain, zones)
    note_compiling(as_paper=False)
    return problem, reports[-1]


def run_mission(args: argparse.Namespace, file: Path, mission: MissionFile) -> int:
    """Judge a mission and print its faults; a fault is a failure."""
    from pathgene.host.mission.foreign.check import check_mission
    from pathgene.host.mission.foreign.files import write_check
    from pathgene.host.mission.foreign.words import counted

    directory = None if args.out is None else Path(args.out)
    if args.write is not None:
        _check_page(directory)
    if directory is not None:
        prepare_directory(directory)
    problem, zones = problem_of_mission(args, file, mission)
    try:
        checked = check_mission(mission, problem, args.return_height)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None
    note_mission(file, checked.reading)
    report = checked.report
    report["read"] = {
        "terrain": problem.terrain.reading.to_dict(),
        "zones": zones.to_dict(),
        **report["read"],
    }
    written = []
    if directory is not None:
        import_quickly()
        page = None if args.write is None else _page(checked, file.name)
        written = write_check(directory, checked, report, file.name, note, page)
    if args.json:
        print_json(report)
    else:
        print_pairs([*checked.pairs, *(("written", str(each)) for each in written)])
        print_lines(checked.lines)
    if checked.faults:
        faults = counted(len(checked.faults), "fault")
        raise JobError(f"The mission is not feasible: {faults}.")
    return 0


def _check_page(directory: Path | None) -> None:
    """Refuse a page without a directory or without the extra that it needs."""
    from pathgene.host.web.page import require_library

    if directory is None:
        raise InputError("--write html needs the directory to write to; give --out.")
    require_library()


def _page(checked: MissionCheck, name: str) -> bytes | None:
    """Return the page of a mission; None for a mission without a leg."""
    from pathgene.host.web.mission_page import page_of_check

    if all(len(chain.points) < 2 for chain in checked.flight.chains):
        note("There is no page, because no leg is flown; see the picture.")
        return None
    return page_of_check(checked, name).encode()


def path_faults(problem: Problem, path: NDArray[np.float64]) -> MissionCheck:
    """Return the faults of a path of the problem's rules."""
    from pathgene.host.mission.foreign.check import check_path
    from pathgene.host.mission.foreign.judge import FlightProblem

    same = FlightProblem(
        problem.terrain,
        problem.start,
        problem.goal,
        problem.aircraft,
        problem.zones,
        problem.wind,
        problem.ds_m,
        rules=problem.rules,
    )
    return check_path(same, path)


def print_lines(lines: Iterable[str]) -> None:
    """Print faults, a line each."""
    for line in lines:
        print(line)


def note_mission(file: Path, reading: Reading) -> None:
    """Print the facts and assumptions of a mission."""
    from pathgene.host.mission.foreign.words import counted

    facts: dict[str, Any] = dict(reading.facts)
    text = f"Mission {file.name}: {facts['kind']}, {counted(facts['items'], 'item')}"
    if facts["heights"]:
        text += f", heights {' and '.join(facts['heights'])}"
    if facts["home"] is not None:
        home = facts["home"]
        text += f", home at {home['lat']:.6f}, {home['lon']:.6f}, {home['altitude_m']:.1f} m"
    if facts["rally_points"]:
        text += f", rally points: {facts['rally_points']}"
    note(f"{text}.")
    if facts["ignored"]:
        note(f"Note: Ignored, as they do not move the aircraft: {', '.join(facts['ignored'])}.")
    for remark in reading.remarks:
        note(f"{remark.grade.capitalize()}: {remark.text}")
