"""``pathgene export``."""

from __future__ import annotations

import argparse
from pathlib import Path

from pathgene.host.cli.last_door import check_path
from pathgene.host.cli.output import note, print_json, print_pairs
from pathgene.host.evaluation import Evaluator
from pathgene.host.files.output import prepare_directory
from pathgene.host.formats.registry import parse_formats
from pathgene.host.mission.export import export
from pathgene.host.report.read import read_run
from pathgene.host.web.page import page_of


__all__ = ["run"]


def run(args: argparse.Namespace) -> int:
    """Write the files and print their names."""
    formats = parse_formats(args.write)
    file = Path(args.summary)
    planned = read_run(file, origin=args.origin)
    directory = file.parent if args.out is None else Path(args.out)
    check_path(planned, "nothing is written", "plan again")
    prepare_directory(directory)
    if planned.feasible is False:
        note("The path is not feasible; look at the files, but do not fly them.")
    notes: list[str] = []

    def page() -> str:
        return page_of(Evaluator(planned.problem), planned.path, planned.summary)

    written = export(planned, formats, directory, notes.append, page=page)
    for sentence in notes:
        note(sentence)
    if args.json:
        files = {name: str(path) for name, path in zip(formats, written, strict=True)}
        print_json({"files": files, "notes": notes})
    else:
        print_pairs(("written", str(path)) for path in written)
    return 0
