"""``pathgene mend``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from pathgene.host.cli.arguments import Commands, add_command, complete_by_file
from pathgene.host.cli.check_mission import (
    add_mission_options,
    note_mission,
    print_lines,
    problem_of_mission,
)
from pathgene.host.cli.output import note, note_start, print_json, print_pairs
from pathgene.host.cli.values import complete_options
from pathgene.host.errors import InputError, JobError
from pathgene.host.files.output import output_file, prepare_file
from pathgene.host.formats.registry import mission_files


if TYPE_CHECKING:
    from pathgene.host.mission.foreign.mend import Mended

__all__ = ["add", "run"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "mend",
        run,
        "Mend a mission of any ground station by the fewest and smallest changes",
        "pathgene mend mission.plan --terrain tile.tif --out mended.plan",
        usage="MISSION [PROBLEM.toml] --out FILE [OPTIONS]",
        notes="The exit status is 0 for a mission that is mended or has no fault, 1 for one that "
        "cannot be mended, 2 for bad input.",
    )
    parser.add_argument("mission", metavar="MISSION", help=mission_files())
    either = parser.add_mutually_exclusive_group(required=True)
    either.add_argument(
        "--out",
        metavar="FILE",
        help="file for the mended mission: a .plan, or a list of waypoints if MISSION is one; "
        "nothing is written unless the mission passes every check",
    )
    either.add_argument("--dry-run", action="store_true", help="list the changes and write nothing")
    add_mission_options(parser)
    complete_by_file(parser, besides=("mission", "out", "dry_run"))


def run(args: argparse.Namespace) -> int:
    """Mend a mission, print the changes and write the file."""
    note_start("Reading the mission.")
    from pathgene.host.mission.foreign.loaded import mission_and_source
    from pathgene.host.mission.foreign.mend import mend

    file = Path(args.mission)
    out = None if args.out is None else Path(args.out)
    complete_options(args)
    mission, source = mission_and_source(file)
    if out is not None:
        prepare_file(out)
    problem, zones = problem_of_mission(args, file, mission)
    try:
        mended = mend(mission, problem, args.return_height)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None
    note_mission(file, mended.before.reading)
    content = None
    if mended.feasible and out is not None:
        content = mended.written(source, file.name, out.name)
        with output_file(out) as stream:
            stream.write(content)
        if mended.is_line:
            note(
                f"Note: {out.name} is a new .plan with the points of {file.name} as waypoints, and "
                "home on the ground below the first."
            )
    for remark in mended.remarks:
        note(f"Note: {remark}")
    written = None if content is None or out is None else str(out)
    if args.json:
        read = {"terrain": problem.terrain.reading.to_dict(), "zones": zones.to_dict()}
        print_json({**mended.report, "read": read, "written": written})
    else:
        _print(mended, written)
    if mended.refusal is not None:
        raise JobError(f"{mended.refusal} Nothing is written.")
    return 0


def _print(mended: Mended, written: str | None) -> None:
    """Print the faults, the changes and the file."""
    nothing = "nothing to mend" if mended.before.feasible else None
    pairs = [
        ("faults", f"{len(mended.before.faults)}, {len(mended.after.faults)} after mending"),
        ("changes", nothing or str(len(mended.changes))),
        ("minimum clearance", dict(mended.after.pairs)["minimum clearance"]),
    ]
    if written is not None:
        pairs.append(("written", written))
    print_pairs(pairs)
    if mended.feasible:
        print_lines(mended.lines)
    else:
        print_lines(mended.after.lines)
