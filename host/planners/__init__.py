"""The planners, by name. Light to import: a planner is loaded when it is made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from host.errors import InputError


if TYPE_CHECKING:
    from host.planners.base import Planner

__all__ = ["DEFAULT", "PLANNERS", "Entry", "make"]

#: What ``pathgene plan`` uses when no planner is named.
DEFAULT = "ga-fpga"


@dataclass(frozen=True)
class Entry:
    """What the registry knows of a planner.

    Parameters
    ----------
    description : str
        One line for users.
    paper : str
        Where it is from.
    options : mapping of str to str
        Options of its own, as keywords of ``constructor``, and what each means.
    constructor : callable
        Returns the planner; loads its module.
    """

    description: str
    paper: str
    options: Mapping[str, str]
    constructor: Callable[..., Planner]


def _ga_fpga(**options: Any) -> Planner:
    from host.planners.ga_fpga import FpgaGeneticPlanner

    return FpgaGeneticPlanner(**options)


def _ga_pc(**options: Any) -> Planner:
    from host.planners.ga_pc import PcGeneticPlanner

    return PcGeneticPlanner(**options)


#: Every planner, the default first.
PLANNERS: Mapping[str, Entry] = {
    "ga-fpga": Entry(
        description="Genetic algorithm on the chip; the host evaluates and sorts",
        paper="Allaire, Tarbouchi, Labonte and Fusina 2008, section 4",
        options={
            "board": "URL of the board",
            "link_mode": "what goes over the link: rank, population or recipe",
            "feasibility": "host or board: who counts the distance under the terrain",
            "initial_draws": "paths drawn for each of the first population; the best go on",
        },
        constructor=_ga_fpga,
    ),
    "ga-pc": Entry(
        description="The same genetic algorithm on the PC alone: the baseline",
        paper="Allaire, Tarbouchi, Labonte and Fusina 2008, section 3",
        options={"max_waypoints": "most transitional waypoints of a path"},
        constructor=_ga_pc,
    ),
}


def make(name: str, **options: Any) -> Planner:
    """Return the planner ``name`` with ``options`` of its own.

    Raises
    ------
    InputError
        If there is no such planner.
    """
    if name not in PLANNERS:
        raise InputError(f"There is no planner {name!r}; the planners are {', '.join(PLANNERS)}.")
    return PLANNERS[name].constructor(**options)
