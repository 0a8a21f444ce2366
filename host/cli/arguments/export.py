"""Arguments of ``pathgene export``."""

from __future__ import annotations

from pathgene.host.cli.arguments.base import Commands, add_command, numbers
from pathgene.host.formats.registry import choices, usual


__all__ = ["add_export"]


def add_export(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "export",
        "export:run",
        "Write a planned path as files for ground stations and viewers",
        "pathgene export out/summary.json --write plan,kml --out mission",
        notes="The path is judged again; if it breaks a limit although its summary calls it "
        "feasible, nothing is written and the exit status is 1. Altitudes are above mean sea "
        "level; docs/files.md describes each file.",
    )
    parser.add_argument("summary", metavar="SUMMARY", help="summary.json of pathgene plan")
    parser.add_argument(
        "--write",
        metavar="LIST",
        default=usual(),
        help=f"some of {choices()} (default %(default)s)",
    )
    parser.add_argument(
        "--out", metavar="DIR", help="directory to write to (default that of the summary)"
    )
    parser.add_argument(
        "--origin",
        type=numbers("LAT,LON"),
        metavar="LAT,LON",
        help="place of the south-west node of a terrain that states none, north up, in WGS84 "
        "degrees",
    )
