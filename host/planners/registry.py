"""The table of planners: one row each. A planner is loaded when it is made."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pathgene.host.errors import InputError
from pathgene.host.planners.options import ENGINES


if TYPE_CHECKING:
    from pathgene.host.planners.base import Planner

__all__ = ["DEFAULT", "ON_PAPER_CORE", "PLANNERS", "Entry", "make"]

#: The planner if none is named, on a board with the paper core:
#: :mod:`pathgene.host.planners.default` decides.
ON_PAPER_CORE = "ga-fpga"


@dataclass(frozen=True)
class Entry:
    """A planner in the registry.

    Parameters
    ----------
    description : str
        One line for users.
    paper : str
        Its source.
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
        generations=40,
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


def make(name: str, **options: Any) -> Planner:
    """Return the planner ``name`` with its own ``options``.

    Raises
    ------
    InputError
        If there is no such planner.
    """
    if not isinstance(name, str) or name not in PLANNERS:
        raise InputError(f"There is no planner {name!r}; the planners are {', '.join(PLANNERS)}.")
    return PLANNERS[name].constructor(**options)
