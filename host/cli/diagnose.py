"""``pathgene diagnose``."""

from __future__ import annotations

import argparse
import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pathgene.host.cli.arguments import Commands, add_command, add_problem, complete_by_file
from pathgene.host.cli.drawing import import_quickly
from pathgene.host.cli.output import (
    note,
    note_compiling,
    note_readings,
    note_start,
    print_json,
    print_pairs,
)
from pathgene.host.cli.values import complete_options
from pathgene.host.errors import JobError, NoPathError
from pathgene.host.files.output import prepare_directory
from pathgene.host.options.kinds import PATH
from pathgene.host.progress import Bar
from pathgene.host.stages import part, watched_by


if TYPE_CHECKING:
    from pathgene.host.diagnosis import Reason
    from pathgene.host.report.write import Drawn


__all__ = ["add", "run"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "diagnose",
        run,
        "Say whether start and goal are connected, or why not",
        "pathgene diagnose --terrain canyon --agl --start 300,300,60 --goal 4700,4600,60 "
        "--ceiling 400 --out out",
        usage="[PROBLEM.toml] [OPTIONS]",
        notes="The exit status is 0 if there is a path, 1 with the reason if none is found, 2 for "
        "bad input.",
    )
    add_problem(parser)
    group = parser.add_argument_group("output")
    group.add_argument(
        "--out",
        type=PATH.parse,
        metavar="DIR",
        help="directory to write diagnosis.json to, and diagnosis.png, the picture that marks the "
        "reason (default: no files, whatever the problem file says)",
    )
    complete_by_file(parser, besides=("out",))


def run(args: argparse.Namespace) -> int:
    """Search for a path; report that one exists, or why the first leg without a path has none."""
    note_start("Reading the problem.")
    from pathgene.host.connection import connect
    from pathgene.host.evaluation import Evaluator
    from pathgene.host.mission.build import mission_of
    from pathgene.host.report.summary import describe_reading

    complete_options(args)
    directory = None if args.out is None else Path(args.out)
    if directory is not None:
        prepare_directory(directory)
    try:
        mission = mission_of(vars(args), say=note_readings)
    except NoPathError as error:
        # Its costs have no reference, so nothing is searched or drawn.
        _tell(args, directory, _report(error.reason, error.leg), [])
        raise
    read = describe_reading(mission.problem)
    note_compiling(as_paper=mission.problem.as_paper)
    planners: list[str] = []
    for number in range(mission.legs):
        evaluator = Evaluator(mission.leg(number))
        with (
            contextlib.closing(Bar(sys.stderr, 1)) as bar,
            watched_by(bar.stage),
            part(mission.name_of(number) if mission.legs > 1 else ""),
        ):
            found = connect(evaluator)
        if found.reason is not None:
            break
        planners.append(str(found.planner))
    leg = mission.name_of(number) if mission.legs > 1 and found.reason is not None else None
    place = f"{mission.problem.terrain.name}{'' if leg is None else f', {leg}'}"
    report = {**_report(found.reason, None if leg is None else number + 1), "read": read}
    _tell(args, directory, report, planners, (evaluator, found.result, place))
    if found.reason is None:
        return 0
    sentence = found.reason.sentence
    raise JobError(sentence if leg is None else f"{leg[:1].upper()}{leg[1:]}: {sentence}")


def _report(reason: Reason | None, leg: int | None) -> dict[str, Any]:
    """Return the output of ``--json``; ``leg`` counts from 1."""
    from pathgene.host.report.summary import version

    return {
        "pathgene": version(),
        "connected": reason is None,
        "leg": leg,
        "reason": None if reason is None else reason.to_dict(),
    }


def _tell(
    args: argparse.Namespace,
    directory: Path | None,
    report: dict[str, Any],
    planners: list[str],
    drawn: Drawn | None = None,
) -> None:
    """Write the files and print the report; ``drawn`` holds the contents of the picture."""
    from pathgene.host.report.write import write_diagnosis

    written = []
    if directory is not None:
        import_quickly()
        written = write_diagnosis(directory, report, drawn, note)
    if args.json:
        print_json(report)
    else:
        print_pairs([*_pairs(report, planners), *(("written", str(file)) for file in written)])


def _pairs(report: dict[str, Any], planners: list[str]) -> list[tuple[str, str]]:
    """Return the report as names and texts; ``planners`` names the planners that found paths."""
    from pathgene.host.diagnosis.reason import listed

    reason = report["reason"]
    if reason is None:
        by = listed(dict.fromkeys(planners))
        return [("connected", f"yes, a feasible path is found by {by}")]
    pairs = [
        ("connected", "no" if reason["proven"] else "not as far as the search sees"),
        ("reason", reason["code"]),
    ]
    if reason["zones"]:
        pairs.append(("zones", ", ".join(reason["zones"])))
    if reason["place"] is not None:
        pairs.append(("place", "{:.1f}, {:.1f} m".format(*reason["place"])))
    if reason["place_geo"] is not None:
        pairs.append(("latitude, longitude", "{:.6f}, {:.6f}".format(*reason["place_geo"])))
    figure = reason["figure"]
    if figure is not None:
        unit = figure["unit"]
        pairs.append((figure["limit"], f"{figure['allowed']:.6g} {unit}"))
        if figure["would_do"] is not None:
            pairs.append(("would do", f"{figure['would_do']:.6g} {unit}"))
    return pairs
