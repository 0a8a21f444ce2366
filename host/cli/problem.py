"""``pathgene problem``."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pathgene.host.cli.arguments import Commands, add_command, add_command_group
from pathgene.host.cli.output import note_readings, print_json, print_pairs
from pathgene.host.errors import InputError
from pathgene.host.files.output import output_file, prepare_file
from pathgene.host.files.special import is_special
from pathgene.host.planners import DEFAULT


if TYPE_CHECKING:
    from pathgene.host.problem.problem import Problem
    from pathgene.host.remarks import Reading

__all__ = ["add", "check", "new"]


def add(commands: Commands) -> None:
    """Add the command and its commands."""
    actions = add_command_group(
        commands,
        "problem",
        "Write and check problem files, which hold all options of a plan",
        "pathgene problem new mine.toml",
    )
    writing = add_command(
        actions,
        "new",
        new,
        "Write a problem file with every key explained, which plans as it is",
        "pathgene problem new mine.toml",
    )
    writing.add_argument(
        "file",
        metavar="FILE",
        nargs="?",
        default="problem.toml",
        help="file to write, which must not exist (default %(default)s)",
    )
    checking = add_command(
        actions,
        "check",
        check,
        "Check a problem file without planning: its keys, values, terrain, points and zones",
        "pathgene problem check problem.toml --json",
        notes="The exit status is 0 for a good file, 2 for a bad one.",
    )
    checking.add_argument("file", metavar="FILE", help="problem file")


def new(args: argparse.Namespace) -> int:
    """Write a template; refuse to replace a file."""
    from pathgene.host.mission.problem_file import template

    file = Path(args.file)
    if file.exists() and not is_special(file):
        raise InputError(f"{str(file)!r} exists; give the name of a new file.")
    prepare_file(file)
    with output_file(file) as binary:
        binary.write(template().encode())
    if args.json:
        print_json({"file": str(file)})
    else:
        print_pairs([("file", str(file)), ("plan it with", f"pathgene plan {file}")])
    return 0


def check(args: argparse.Namespace) -> int:
    """Read a problem file, build its mission, and describe the mission."""
    from pathgene.host.mission.autopilot.hand_over import choices_of
    from pathgene.host.mission.build import mission_of, search_of
    from pathgene.host.mission.problem_file import read_problem
    from pathgene.host.planners import asks_hardware
    from pathgene.host.problem.tiles import wholes
    from pathgene.host.report.summary import describe_reading

    values = read_problem(Path(args.file))
    # A check does not need the hardware.
    is_asked = asks_hardware(values.get("planner"), values.get("board"))
    search = search_of({**values, "planner": DEFAULT, "board": None} if is_asked else values)
    read: list[tuple[Reading, Reading]] = []
    try:
        mission = mission_of(values, say=lambda *readings: read.append(readings))
    except InputError:
        # The files that were read may show the cause of the refusal.
        for terrain, zones in read:
            note_readings(terrain, zones)
        raise
    problem = mission.problem
    ending = choices_of(values, problem).ending
    report: dict[str, Any] = {
        "file": args.file,
        "terrain": problem.terrain.describe(),
        "uav": problem.aircraft.name,
        "zones": len(wholes(problem.zones)),
        "read": describe_reading(problem),
        "points": [list(point) for point in mission.way],
        "legs": mission.legs,
        "end": ending.to_dict(),
        "straight_m": mission.straight_m,
        "as_paper": problem.as_paper,
        "rules": None if problem.rules is None else problem.rules.to_dict(),
        "planner": None if is_asked else search.planner,
        "generations": values.get("generations") if is_asked else search.options.generations,
        "seed": search.options.seed,
    }
    if args.json:
        print_json(report)
    else:
        from pathgene.host.report.reading import terrain_in_words

        rules = "none, as paper"
        if problem.rules is not None:
            rules = f"clearance {problem.rules.clearance_m:g} m"
        names = zip(mission.names, mission.way, strict=True)
        print_pairs(
            [
                ("terrain", terrain_in_words(report["read"]["terrain"]) or problem.terrain.name),
                ("aircraft", problem.aircraft.name),
                ("no-fly zones", str(report["zones"])),
                *_read(problem),
                *((name, f"{x:.1f}, {y:.1f}, altitude {z:.1f} m") for name, (x, y, z) in names),
                ("end", ending.kind),
                ("straight lines", f"{report['straight_m']:.1f} m"),
                ("rules", rules),
                ("planner", "the board's" if is_asked else search.planner),
            ]
        )
    return 0


def _read(problem: Problem) -> Iterator[tuple[str, str]]:
    """Yield the report on files that were read: each zone on the map, and the remarks."""
    for file in problem.zones_reading.facts.get("files", ()):
        for zone in file["zones"]:
            limits = f"{zone['lower'] or 'ground'} to {zone['upper'] or 'the sky'}"
            parts = (zone["part"], limits, zone["times"], zone["reason"])
            yield "  zone", ", ".join(part for part in parts if part)
    for remark in (*problem.terrain.reading.remarks, *problem.zones_reading.remarks):
        yield f"  {remark.grade}", remark.text
