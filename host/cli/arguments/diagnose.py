"""Arguments of ``pathgene diagnose``."""

from __future__ import annotations

from pathgene.host.cli.arguments.base import Commands, add_command, complete_by_file
from pathgene.host.cli.arguments.problem import add_problem


__all__ = ["add_diagnose"]


def add_diagnose(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "diagnose",
        "diagnose:run",
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
        metavar="DIR",
        help="directory to write diagnosis.json to, and diagnosis.png, the picture that marks the "
        "reason (default: no files, whatever the problem file says)",
    )
    complete_by_file(parser, besides=("out",))
