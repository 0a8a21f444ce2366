"""The planners, by name. Light to import: a planner is loaded when it is made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pathgene.host.errors import InputError
from pathgene.host.planners.options import ENGINES, OPTIONS, Option


if TYPE_CHECKING:
    from pathgene.host.planners.base import Planner

__all__ = ["DEFAULT", "ENGINES", "OPTIONS", "PLANNERS", "Entry", "Option", "make"]

#: The planner where none is named: :mod:`pathgene.host.planners.default` has the exception.
DEFAULT = "ga-chip"


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
        Names in :data:`OPTIONS` that are keywords of ``constructor``.
    constructor : callable
        Returns the planner; loads its module.
    engines : tuple of str
        Engines that it can run on, the default first.
    """

    description: str
    paper: str
    generations: int
    options: tuple[str, ...]
    constructor: Callable[..., Planner]
    engines: tuple[str, ...] = ("threads",)


def _ga_fpga(**options: Any) -> Planner:
    from pathgene.host.planners.ga_fpga import FpgaGeneticPlanner

    return FpgaGeneticPlanner(**options)


def _ga_chip(**options: Any) -> Planner:
    from pathgene.host.planners.ga_chip import ChipGeneticPlanner

    return ChipGeneticPlanner(**options)


def _ga_pc(**options: Any) -> Planner:
    from pathgene.host.planners.ga_pc import PcGeneticPlanner

    return PcGeneticPlanner(**options)


def _astar(**options: Any) -> Planner:
    from pathgene.host.planners.astar import AstarPlanner

    return AstarPlanner(**options)


def _fpa(**options: Any) -> Planner:
    from pathgene.host.planners.fpa.planner import FlowerPollinationPlanner

    return FlowerPollinationPlanner(two_opt_every=0, **options)


def _fpa_2opt(**options: Any) -> Planner:
    from pathgene.host.planners.fpa.planner import FlowerPollinationPlanner

    return FlowerPollinationPlanner(**options)


def _ga_dp(**options: Any) -> Planner:
    from pathgene.host.planners.spline_routes import DeterministicRoutePlanner

    return DeterministicRoutePlanner(**options)


def _ga_auv(**options: Any) -> Planner:
    from pathgene.host.planners.spline_routes import ConventionalRoutePlanner

    return ConventionalRoutePlanner(**options)


#: Every planner, the default first.
PLANNERS: Mapping[str, Entry] = {
    "ga-chip": Entry(
        description="Genetic algorithm that runs on the chip alone; the host has the last word",
        paper="none: the chip's loop as Allaire and others 2008 hope for it",
        generations=8_000,
        options=("board", "chip_ms", "polish"),
        constructor=_ga_chip,
        engines=("chip",),
    ),
    "ga-fpga": Entry(
        description="Genetic algorithm on the chip; the host evaluates and sorts",
        paper="Allaire, Tarbouchi, Labonte and Fusina 2008, section 4",
        generations=300,
        options=("board", "link_mode", "feasibility", "initial_draws", "init"),
        constructor=_ga_fpga,
        engines=("chip",),
    ),
    "ga-pc": Entry(
        description="The same genetic algorithm on the PC alone: the baseline",
        paper="Allaire, Tarbouchi, Labonte and Fusina 2008, section 3",
        generations=300,
        options=("max_waypoints", "init", "refits"),
        constructor=_ga_pc,
    ),
    "astar": Entry(
        description="Grid search, few waypoints, lowest altitudes: what to beat",
        paper="none: the search is Dijkstra's, the altitudes are a linear program's",
        generations=40,
        options=("max_waypoints",),
        constructor=_astar,
    ),
    "fpa": Entry(
        description="Flower pollination algorithm",
        paper="Roberge and Tarbouchi, parallel hybrid 2-opt FPA, section 3.3",
        generations=500,
        options=("engine", "waypoints", "init"),
        constructor=_fpa,
        engines=ENGINES,
    ),
    "fpa-2opt": Entry(
        description="The same with 2-opt, which takes loops out of the paths",
        paper="Roberge and Tarbouchi, parallel hybrid 2-opt FPA, section 3.4",
        generations=500,
        options=("engine", "waypoints", "two_opt_every", "init"),
        constructor=_fpa_2opt,
        engines=ENGINES,
    ),
    "ga-dp": Entry(
        description="B-spline routes; crossover by dynamic programming over all segments",
        paper="Cheng, Fallahi, Leung and Tse, GA with a deterministic crossover operator, "
        "section IV",
        generations=100,
        options=("reading", "draws", "added_points", "init"),
        constructor=_ga_dp,
    ),
    "ga-auv": Entry(
        description="B-spline routes; the conventional GA that ga-dp is compared with",
        paper="Cheng, Fallahi, Leung and Tse, GA with a deterministic crossover operator, "
        "section V",
        generations=100,
        options=("draws", "added_points", "init"),
        constructor=_ga_auv,
    ),
}


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
