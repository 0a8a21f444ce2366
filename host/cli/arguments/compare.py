"""Arguments of ``pathgene compare``."""

from __future__ import annotations

from pathgene.host.cli.arguments.base import Commands, add_command, complete_by_file
from pathgene.host.cli.arguments.problem import add_problem
from pathgene.host.cli.arguments.search import add_own_options, add_search
from pathgene.host.planners import PLANNERS
from pathgene.host.workers import LOCAL


__all__ = ["add_compare"]


def add_compare(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "compare",
        "compare:run",
        "Compare planners over many seeds",
        "pathgene compare --planners ga-fpga,ga-pc,ga-pc:max_waypoints=8 --terrain tile.tif "
        "--start 1200,1200,100 --goal 14000,14000,100 --agl --runs 5 --generations 20 "
        "--out out/compare",
        usage="[PROBLEM.toml] --planners NAME,... [OPTIONS]",
    )
    add_problem(parser)
    group = parser.add_argument_group("comparison")
    group.add_argument(
        "--planners",
        metavar="NAME[:KEY=VALUE]...,...",
        required=True,
        help=f"some of {', '.join(PLANNERS)}; options of one entry alone follow its name, as in "
        "ga-pc:max_waypoints=8:generations=500; a planner may be listed several times",
    )
    group.add_argument(
        "--runs",
        type=int,
        metavar="N",
        default=50,
        help="runs of each planner, with consecutive seeds (default %(default)s)",
    )
    group.add_argument(
        "--seed",
        type=int,
        metavar="N",
        default=0,
        help="seed of the first run (default %(default)s)",
    )
    group.add_argument(
        "--jobs",
        type=int,
        metavar="N",
        help="simultaneous runs, each in a process (default one per core)",
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS|local",
        nargs="?",
        const=LOCAL,
        help="run on the Dask cluster at this address, or on one started here for these runs "
        "(local, or no address); needs the extra pathgene[cluster]",
    )
    group = parser.add_argument_group("planning")
    add_search(group)
    add_own_options(parser)
    group = parser.add_argument_group("output")
    group.add_argument(
        "--out",
        metavar="DIR",
        default="out/compare",
        help="directory to write to; runs that it already holds are not repeated "
        "(default %(default)s)",
    )
    complete_by_file(parser, besides=("planners", "runs", "seed", "jobs", "scheduler", "out"))
