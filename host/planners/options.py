"""Options that some planners have, as users give them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pathgene.host.old_words import current_engine


__all__ = ["DEFAULT_BOARD", "ENGINES", "OPTIONS", "Option"]

#: Engines of the planners that have a choice, the default first.
ENGINES = ("threads", "sequential", "gpu")

#: Board where none is named: the software model.
DEFAULT_BOARD = "model:"


@dataclass(frozen=True, kw_only=True)
class Option:
    """An option that only some planners have.

    Parameters
    ----------
    meaning : str
        Its meaning and default, for users.
    type : callable
        Converts its text to its value.
    metavar : str, optional
        Placeholder of the value in the help.
    choices : tuple of str
        All its values, if they are few.
    """

    meaning: str
    type: Callable[[str], Any] = str
    metavar: str | None = None
    choices: tuple[str, ...] = ()


#: Options of planners, by the keyword of their constructors; ``--like-this`` on a command line.
OPTIONS: Mapping[str, Option] = {
    "board": Option(
        meaning="model:, sim:, sim:?sim=icarus, a serial device or a URL of pyserial (default "
        f"{DEFAULT_BOARD})",
        metavar="URL",
    ),
    "chip_ms": Option(
        meaning="most milliseconds of a plan by the chip's clock, runs without a path not counted "
        "(default: no limit but the generations)",
        type=int,
        metavar="MS",
    ),
    "polish": Option(
        meaning="give the chip's paths the lowest altitudes on the host, too (default on)",
        choices=("on", "off"),
    ),
    "link_mode": Option(
        meaning="data sent over the link in each generation (default rank)",
        choices=("rank", "population", "recipe"),
    ),
    "feasibility": Option(
        meaning="side that counts the distance under the terrain during the search; the report is "
        "always the host's (default host)",
        choices=("host", "board"),
    ),
    "initial_draws": Option(
        meaning="paths drawn for each path of the first population, which keeps the best (default "
        "4; the paper's is 1)",
        type=int,
        metavar="N",
    ),
    "engine": Option(
        meaning="all threads, one thread, or an NVIDIA GPU; the GPU rounds differently (default "
        "threads)",
        type=current_engine,
        choices=ENGINES,
    ),
    "waypoints": Option(
        meaning="free waypoints of every path (default 6, with --init astar 16)",
        type=int,
        metavar="N",
    ),
    "two_opt_every": Option(
        meaning="iterations from one 2-opt to the next (default 20), 0 for none",
        type=int,
        metavar="N",
    ),
    "max_waypoints": Option(
        meaning="most transitional waypoints of a path (default 20, of astar 16)",
        type=int,
        metavar="N",
    ),
    "init": Option(
        meaning="first population: random, or astar: the paths that the planner astar finds, and "
        "varied copies of them (default random)",
        choices=("random", "astar"),
    ),
    "refits": Option(
        meaning="children of a generation that are the best path with one or two waypoints moved "
        "and the lowest altitudes (default 2 with --init astar, else 0)",
        type=int,
        metavar="N",
    ),
    "reading": Option(
        meaning="cost of a route in the crossover: that of the whole route, or the sum of its "
        "segments' costs (default route)",
        choices=("route", "sum"),
    ),
    "draws": Option(
        meaning="draw crossover points and segments near the best route or, as in the paper, "
        "anywhere (default near)",
        choices=("near", "uniform"),
    ),
    "added_points": Option(
        meaning="crossover points added per generation (default 8)", type=int, metavar="N"
    ),
}
