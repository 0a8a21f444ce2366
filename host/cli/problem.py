"""The problem that the options and the problem file describe."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

from pathgene.host.compare.entrants import planner_names
from pathgene.host.errors import InputError
from pathgene.host.inputs import exists
from pathgene.host.mission.build import (
    end_of,
    mission_of,
    placed_at,
    rules_of,
    terrain_of,
    zones_of,
)
from pathgene.host.mission.keys import RULES, TOGETHER
from pathgene.host.mission.mission import Mission
from pathgene.host.mission.problem_file import read_problem, save_problem
from pathgene.host.planners import OPTIONS, PLANNERS
from pathgene.host.problem.ends import Point
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


__all__ = [
    "complete_options",
    "end_point",
    "file_values",
    "load_terrain",
    "load_zones",
    "make_mission",
    "make_problem",
    "placed",
    "rule_arguments",
    "save_options",
    "source_of",
]


def file_values(args: argparse.Namespace) -> dict[str, Any]:
    """Return the values of the problem file that no option replaces; none without a file.

    An option replaces all that the file says about the same: ``--start-geo`` also a ``start``, one
    zone all zones, ``--as-paper`` the rules. Where planners are named, the options of the file that
    none of them has are left out.

    Raises
    ------
    InputError
        If the problem file is bad.
    """
    given = set(vars(args))
    values = {} if args.problem is None else read_problem(Path(args.problem))
    replaced = {name for group in TOGETHER if given & set(group) for name in group}
    if "as_paper" in given:
        replaced |= set(RULES) if args.as_paper else set()
    elif given & set(RULES):
        replaced.add("as_paper")
    planners = [args.planner] if "planner" in given else []
    if "planners" in given:
        planners = planner_names(args.planners)
    if planners:
        having = [PLANNERS[planner].options for planner in planners if planner in PLANNERS]
        replaced |= set(OPTIONS).difference(*having)
    return {
        name: value for name, value in values.items() if value is not None and name not in replaced
    }


def complete_options(args: argparse.Namespace) -> None:
    """Set the options that are not given: from the problem file, else to their defaults.

    Raises
    ------
    InputError
        If the problem file is bad.
    """
    given = set(vars(args))
    values = file_values(args)
    for name, default in args.option_defaults.items():
        if name not in given:
            setattr(args, name, values.get(name, default))
    args.zones = values.get("zones", [])


def save_options(args: argparse.Namespace, file: Path) -> None:
    """Write the problem file of completed options: those that differ from their defaults.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    # What defaults may become another day.
    stated = {"planner", "seed"}
    values = {
        name: value
        for name, value in vars(args).items()
        if name in stated or value != args.option_defaults.get(name)
    }
    own = PLANNERS[args.planner].options
    save_problem(
        file, {name: value for name, value in values.items() if name not in OPTIONS or name in own}
    )


def load_terrain(args: argparse.Namespace) -> Terrain:
    """Load the terrain of ``--terrain``, ``--fill-voids`` and ``--cell``, at ``--origin``."""
    return terrain_of(vars(args))


def placed(args: argparse.Namespace, terrain: Terrain) -> Terrain:
    """Return the terrain with its south-west node at ``--origin``, if that is given."""
    return placed_at(vars(args), terrain)


def source_of(args: argparse.Namespace) -> dict[str, Any]:
    """Return the origin of the terrain, as a summary states it."""
    path = Path(args.terrain)
    return {
        "source": os.path.realpath(path) if exists(path) else args.terrain,
        "fill_voids": args.fill_voids,
        "cell_m": args.cell and list(args.cell),
    }


def load_zones(args: argparse.Namespace, terrain: Terrain) -> tuple[Zone, ...]:
    """Return the no-fly zones of ``--nofly``, ``--nofly-circle`` and the problem file."""
    return zones_of(vars(args), terrain)


def end_point(args: argparse.Namespace, name: str, terrain: Terrain) -> Point | None:
    """Return start or goal in local metres, with the third number as given."""
    return end_of(vars(args), name, terrain)


def make_mission(args: argparse.Namespace) -> Mission:
    """Return the mission of ``pathgene plan``.

    Raises
    ------
    InputError
        If an option is bad or missing.
    """
    return mission_of(vars(args))


def make_problem(args: argparse.Namespace) -> Problem:
    """Return the problem of a command that has no missions.

    Raises
    ------
    InputError
        If an option is bad or missing, or there are via points or a return.
    """
    mission = make_mission(args)
    if mission.legs > 1:
        raise InputError("Only single legs can be compared; leave via points and return out.")
    return mission.problem


def rule_arguments(args: argparse.Namespace) -> dict[str, Any]:
    """Return the keywords of :class:`Problem` that the options of the rules give.

    Raises
    ------
    InputError
        If a rule is out of range, or is given with ``--as-paper``.
    """
    return rules_of(vars(args))
