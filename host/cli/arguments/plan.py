"""Arguments of ``pathgene plan``."""

from __future__ import annotations

import argparse

from pathgene.host.cli.arguments.base import Commands, add_command, complete_by_file
from pathgene.host.cli.arguments.problem import add_problem
from pathgene.host.cli.arguments.search import (
    DEFAULT_PLANNER,
    add_fallback,
    add_own_options,
    add_search,
)
from pathgene.host.formats.registry import choices
from pathgene.host.planners import PLANNERS


__all__ = ["add_plan"]


def add_plan(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "plan",
        "plan:run",
        "Plan a path and write it with a summary and a picture",
        "pathgene plan --terrain tile.tif --start 1200,1200,100 --goal 14000,14000,100 --agl "
        "--nofly-circle 7000,7000,900 --board sim: --out out",
        usage="[PROBLEM.toml] [OPTIONS]",
        notes="The exit status is 0 with a feasible path, 1 without one, 2 for bad input.",
    )
    add_problem(parser)
    group = parser.add_argument_group("planning")
    group.add_argument(
        "--planner",
        metavar="NAME",
        help=f"one of {', '.join(PLANNERS)} ({DEFAULT_PLANNER})",
    )
    add_search(group)
    group.add_argument(
        "--beside",
        metavar="NAME,...",
        help="planners to run afterwards on the same problem, for a table of all; nothing of "
        "theirs is written",
    )
    group.add_argument(
        "--seed",
        type=int,
        metavar="N",
        default=0,
        help="seed of all random draws; the same seed gives the same result (default %(default)s)",
    )
    add_fallback(group)
    add_own_options(parser)
    group = parser.add_argument_group("output")
    group.add_argument(
        "--out", metavar="DIR", default="out", help="directory to write to (default %(default)s)"
    )
    group.add_argument(
        "--write",
        metavar="LIST",
        default="",
        help=f"write files of these formats as well, as in plan,kml: {choices()}; path.geojson is "
        "always written",
    )
    group.add_argument(
        "--picture",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="draw path.png (default); otherwise remove one of an earlier run",
    )
    group.add_argument(
        "--grid",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="write terrain.npz, the grid that the path was evaluated on (default); otherwise "
        "remove one of an earlier run, and pathgene check loads the terrain from its source",
    )
    group.add_argument(
        "--save-problem",
        metavar="FILE",
        help="write a problem file, .toml, of these options before planning",
    )
    complete_by_file(parser, besides=("beside", "save_problem"))
