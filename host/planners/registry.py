"""The table of planners, one row each, and the default choice.

A planner is loaded when it is made.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pathgene.host.errors import InputError
from pathgene.host.suggestion import did_you_mean


if TYPE_CHECKING:
    from pathgene.host.device.chip import Chip
    from pathgene.host.planners.base import Planner


__all__ = [
    "DEFAULT",
    "DEFAULT_BOARD",
    "DEFAULT_TEXT",
    "ENGINES",
    "PLANNERS",
    "Entry",
    "asks_hardware",
    "default_planner",
    "make",
    "named_or_default",
]


#: Engines of the planners that have a choice, the default first.
ENGINES = ("threads", "sequential", "gpu")

#: The board if none is named: the software model.
DEFAULT_BOARD = "model:"


# The default planner on a board with the paper core.
_ON_PAPER_CORE = "ga-fpga"


@dataclass(frozen=True)
class Entry:
    """A planner in the registry.

    Parameters
    ----------
    generations : int
        Generations that it runs by default.
    options : tuple of str
        Names of its own options in :mod:`pathgene.host.options.table`, keywords of
        ``constructor``.
    constructor : callable
        Returns the planner and loads its module: :func:`_lazy` makes one.
    engines : tuple of str
        Engines that it can run on, the default first.
    """

    description: str
    paper: str
    generations: int
    options: tuple[str, ...]
    constructor: Callable[..., Planner]
    engines: tuple[str, ...] = ("threads",)


def _lazy(place: str, **fixed: Any) -> Callable[..., Planner]:
    """Return a constructor that imports the class at ``place`` when a planner is made.

    Parameters
    ----------
    place : str
        ``module:class`` inside this package.
    **fixed
        Arguments of every planner that the constructor makes.
    """
    module, _, name = place.partition(":")

    def constructor(**options: Any) -> Planner:
        loaded = importlib.import_module(f"pathgene.host.planners.{module}")
        planner: Planner = getattr(loaded, name)(**fixed, **options)
        return planner

    return constructor


#: Every planner; the default comes first.
PLANNERS: Mapping[str, Entry] = {
    "ga-chip": Entry(
        description="Genetic algorithm that runs on the chip alone; the host has the last word",
        paper="none: the chip's loop as Allaire and others 2008 hope for it",
        generations=8_000,
        options=("board", "chip_ms", "polish"),
        constructor=_lazy("chip.ga_chip:ChipGeneticPlanner"),
        engines=("chip",),
    ),
    "ga-fpga": Entry(
        description="Genetic algorithm on the chip; the host evaluates and sorts",
        paper="Allaire, Tarbouchi, Labonte and Fusina 2008, section 4",
        generations=300,
        options=("board", "link_mode", "feasibility", "initial_draws", "init"),
        constructor=_lazy("allaire.ga_fpga:FpgaGeneticPlanner"),
        engines=("chip",),
    ),
    "ga-pc": Entry(
        description="The same genetic algorithm on the PC alone: the baseline",
        paper="Allaire, Tarbouchi, Labonte and Fusina 2008, section 3",
        generations=300,
        options=("max_waypoints", "init", "refits"),
        constructor=_lazy("allaire.ga_pc:PcGeneticPlanner"),
    ),
    "astar": Entry(
        description="Grid search, few waypoints, lowest altitudes: what to beat",
        paper="none: the search is Dijkstra's, the altitudes are a linear program's",
        generations=400,
        options=("max_waypoints",),
        constructor=_lazy("grid.astar:AstarPlanner"),
    ),
    "fpa": Entry(
        description="Flower pollination algorithm",
        paper="Roberge and Tarbouchi, parallel hybrid 2-opt FPA, section 3.3",
        generations=500,
        options=("engine", "waypoints", "init"),
        constructor=_lazy("fpa.planner:FlowerPollinationPlanner", two_opt_every=0),
        engines=ENGINES,
    ),
    "fpa-2opt": Entry(
        description="The same with 2-opt, which takes loops out of the paths",
        paper="Roberge and Tarbouchi, parallel hybrid 2-opt FPA, section 3.4",
        generations=500,
        options=("engine", "waypoints", "two_opt_every", "init"),
        constructor=_lazy("fpa.planner:FlowerPollinationPlanner"),
        engines=ENGINES,
    ),
    "ga-dp": Entry(
        description="B-spline routes; crossover by dynamic programming over all segments",
        paper="Cheng, Fallahi, Leung and Tse, GA with a deterministic crossover operator, "
        "section IV",
        generations=100,
        options=("reading", "draws", "added_points", "init"),
        constructor=_lazy("routes.spline_routes:DeterministicRoutePlanner"),
    ),
    "ga-auv": Entry(
        description="B-spline routes; the conventional GA that ga-dp is compared with",
        paper="Cheng, Fallahi, Leung and Tse, GA with a deterministic crossover operator, "
        "section V",
        generations=100,
        options=("draws", "added_points", "init"),
        constructor=_lazy("routes.spline_routes:ConventionalRoutePlanner"),
    ),
}

#: The planner if none is named, on all other boards.
DEFAULT = next(iter(PLANNERS))
#: The rule of :func:`default_planner` in words.
DEFAULT_TEXT = f"{DEFAULT}, on a board with the paper core {_ON_PAPER_CORE}"


def make(name: str, **options: Any) -> Planner:
    """Return the planner ``name`` with its own ``options``.

    Raises
    ------
    InputError
        If there is no such planner.
    """
    if not isinstance(name, str) or name not in PLANNERS:
        raise InputError(
            f"There is no planner {name!r}{did_you_mean(name, PLANNERS)}; the planners are "
            f"{', '.join(PLANNERS)}."
        )
    return PLANNERS[name].constructor(**options)


def default_planner(board: str | Chip | None = None) -> str:
    """Return the planner for the core of a board: ``ga-fpga`` on the paper core.

    In all other cases it is ``ga-chip``: without a board, with the planner core, and on a simulated
    board, which is built as its planner needs it. A simulated board has the paper core if its URL
    has parameters that only this core takes.

    Parameters
    ----------
    board : str or Chip, optional
        URL of the board, or an open one. Hardware is opened and queried.

    Raises
    ------
    InputError, JobError
        If hardware does not answer, as for :func:`pathgene.host.device.boards.open_board`.
    """
    if board is None:
        return DEFAULT
    # Loads the protocol and the ports.
    from pathgene.hdl.config import GeneticCore
    from pathgene.host.device.boards import known_config, open_board, with_core
    from pathgene.host.device.chip import Chip

    if isinstance(board, Chip):
        config = board.config
    else:
        url = with_core(board, GeneticCore.PLANNER)
        try:
            known = known_config(url)
        except InputError:
            # An error with both cores is reported when the board is opened.
            return _ON_PAPER_CORE
        if known is None:
            with open_board(url) as chip:
                known = chip.config
        config = known
    return _ON_PAPER_CORE if config.paper_core else DEFAULT


def asks_hardware(planner: str | None, board: str | None) -> bool:
    """Return True if the planner is the default one, which depends on the hardware.

    Parameters
    ----------
    planner : str or None
        Name of a planner; None if not given.
    board : str or None
        URL of the board; None if not given.
    """
    if planner is not None or board is None:
        return False
    from pathgene.host.device.boards import known_config

    return known_config(board) is None


def named_or_default(planner: str | None, options: Mapping[str, Any]) -> str:
    """Return ``planner``, or if it is None, the default planner for the board in ``options``.

    Parameters
    ----------
    options : mapping
        Options in :data:`pathgene.host.options.table.OWN`; None stands for the default.

    Raises
    ------
    InputError
        If the default planner lacks a given option, or as :func:`default_planner` does.
    JobError
        As :func:`default_planner`.
    """
    if planner is not None:
        return planner
    board = options.get("board")
    name = default_planner(board)
    for option, value in options.items():
        if value is None or option in PLANNERS[name].options:
            continue
        having = [other for other, entry in PLANNERS.items() if option in entry.options]
        if having:
            where = "" if board is None else " of this board"
            raise InputError(
                f"The default planner{where}, {name}, has no option {option} "
                f"(--{option.replace('_', '-')}); name a planner that has it (--planner): "
                f"{', '.join(having)}."
            )
    return name
