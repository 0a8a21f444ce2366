"""Arguments of ``pathgene batch``."""

from __future__ import annotations

import argparse

from pathgene.host.cli.arguments.base import Commands, add_command, leave_unset
from pathgene.host.cli.arguments.rules import add_as_paper
from pathgene.host.cli.arguments.search import (
    DEFAULT_PLANNER,
    add_fallback,
    add_own_options,
    add_search,
)
from pathgene.host.planners import PLANNERS
from pathgene.host.workers import LOCAL


__all__ = ["add_batch"]


def add_batch(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "batch",
        "batch:run",
        "Plan many problem files, in several processes or on a Dask cluster",
        "pathgene batch north.toml south.toml --jobs 2 --out out/batch",
        usage="PROBLEM.toml... [OPTIONS]",
        notes="The exit status is 0 if every problem has a feasible path, 2 if bad input alone is "
        "to blame, 1 otherwise.",
    )
    parser.add_argument(
        "problems", metavar="PROBLEM.toml", nargs="+", help="problem files; see pathgene problem"
    )
    group = parser.add_argument_group("planning, in place of what the files say")
    group.add_argument(
        "--planner", metavar="NAME", help=f"one of {', '.join(PLANNERS)} ({DEFAULT_PLANNER})"
    )
    add_search(group)
    group.add_argument("--seed", type=int, metavar="N", help="seed of all random draws (default 0)")
    add_fallback(group)
    add_as_paper(group)
    add_own_options(parser)
    group = parser.add_argument_group("execution")
    group.add_argument(
        "--jobs",
        type=int,
        metavar="N",
        help="problems planned at a time, each in a process (default one per core)",
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS|local",
        nargs="?",
        const=LOCAL,
        help="plan on the Dask cluster at this address, or on one started here (local, or no "
        "address); needs the extra pathgene[cluster]",
    )
    group = parser.add_argument_group("output")
    group.add_argument(
        "--out",
        metavar="DIR",
        default="out/batch",
        help="directory to write to, a folder for each problem; a problem whose result it holds is "
        "not planned again (default %(default)s)",
    )
    group.add_argument(
        "--picture",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="draw path.png of each (default)",
    )
    group.add_argument(
        "--grid",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="write terrain.npz of each (default)",
    )
    leave_unset(parser, besides=("problems", "jobs", "scheduler", "out"))
