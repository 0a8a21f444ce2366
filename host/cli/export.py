"""``pathgene export``."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from pathgene.host.cli.arguments import Commands, add_command, add_end, add_option
from pathgene.host.cli.last_door import check_path, ending_for
from pathgene.host.cli.output import note, note_reading, note_start, print_json, print_pairs
from pathgene.host.formats.registry import choices, parse_formats, usual
from pathgene.host.options.kinds import PATH
from pathgene.host.options.table import NAMED


__all__ = ["add", "run"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "export",
        run,
        "Write a planned path as files for ground stations and viewers",
        "pathgene export out/summary.json --write plan,kml --out mission",
        notes="The path is judged again; if it breaks a limit although its summary calls it "
        "feasible, climbs too late for an autopilot, or the end of the mission has no room, "
        "nothing is written and the exit status is 1. Altitudes are above mean sea level; "
        "docs/files.md describes each file.",
    )
    parser.add_argument("summary", metavar="SUMMARY", help="summary.json of pathgene plan")
    parser.add_argument(
        "--write",
        metavar="LIST",
        default=usual(),
        help=f"some of {choices()} (default %(default)s)",
    )
    parser.add_argument(
        "--out",
        type=PATH.parse,
        metavar="DIR",
        help="directory to write to (default: the folder of the summary)",
    )
    add_option(parser, NAMED["origin"])
    add_option(parser, NAMED["fence_corners"])
    add_option(parser, NAMED["simplify"])
    add_end(parser)


def run(args: argparse.Namespace) -> int:
    """Write the files and print their names."""
    note_start("Reading the plan.")
    from pathgene.host.evaluation import Evaluator
    from pathgene.host.mission.autopilot.hand_over import hand_over_of
    from pathgene.host.mission.export import export
    from pathgene.host.report.read import read_run

    formats = parse_formats(args.write)
    wanted = hand_over_of(vars(args))
    file = Path(args.summary)
    planned = read_run(file, origin=args.origin)
    note_reading(planned.summary.get("read"))
    directory = file.parent if args.out is None else Path(args.out)
    wanted = replace(wanted, ending=ending_for(args, planned))
    check_path(planned, "nothing is written", "plan again")
    if planned.feasible is False:
        note("The path is not feasible; look at the files, but do not fly them.")
    notes: list[str] = []

    def page() -> str:
        from pathgene.host.web.page import page_of

        return page_of(Evaluator(planned.problem), planned.path, planned.summary, wanted)

    written = export(planned, formats, directory, notes.append, page=page, wanted=wanted)
    for sentence in notes:
        note(sentence)
    if args.json:
        files = {name: str(path) for name, path in zip(formats, written, strict=True)}
        print_json({"files": files, "notes": notes})
    else:
        print_pairs(("written", str(path)) for path in written)
    return 0
