"""Arguments of ``pathgene check``."""

from __future__ import annotations

from pathgene.host.cli.arguments.base import Commands, add_command, complete_by_file
from pathgene.host.cli.arguments.problem import add_problem


__all__ = ["add_check"]


def add_check(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "check",
        "check:run",
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
        "options that are not given",
    )
    add_problem(parser, of_path=True)
    complete_by_file(parser, besides=("path",))
