"""The values of a command: its options, completed by a problem file."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pathgene.host.cli.output import note
from pathgene.host.options.table import NAMED, OWN, RULES, TOGETHER
from pathgene.host.planners import PLANNERS


__all__ = [
    "complete_options",
    "file_values",
    "ignored_options",
    "own_options",
    "save_options",
    "source_of",
]


def file_values(args: argparse.Namespace) -> dict[str, Any]:
    """Return the values of the problem file that no option replaces; none without a file.

    An option replaces all values of the file for the same subject: ``--start-geo`` replaces a
    ``start``, one zone replaces all zones, ``--as-paper`` replaces the rules. If planners are
    named, options of the file that none of them has are left out.

    Raises
    ------
    InputError
        If the problem file is bad.
    """
    given = set(vars(args))
    values = {}
    if args.problem is not None:
        from pathgene.host.mission.problem_file import read_problem

        values = read_problem(Path(args.problem))
    replaced = {name for group in TOGETHER if given & set(group) for name in group}
    if "as_paper" in given:
        replaced |= set(RULES) if args.as_paper else set()
    elif given & set(RULES):
        replaced.add("as_paper")
    planners = [args.planner] if "planner" in given else []
    if "planners" in given:
        from pathgene.host.compare.entrants import planner_names

        planners = planner_names(args.planners)
    if planners:
        having = [PLANNERS[planner].options for planner in planners if planner in PLANNERS]
        replaced |= set(OWN).difference(*having)
    return {
        name: value for name, value in values.items() if value is not None and name not in replaced
    }


def complete_options(args: argparse.Namespace) -> None:
    """Set the options that are not given from the problem file, or to their defaults.

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
    """Write completed options as a problem file, leaving out options at their defaults.

    Raises
    ------
    InputError
        If it cannot be written.
    """
    from pathgene.host.mission.problem_file import save_problem

    # These are written even at their defaults, because a later version may have other defaults.
    stated = {"planner", "seed"}
    own = PLANNERS[args.planner].options
    save_problem(
        file,
        {
            name: value
            for name, value in vars(args).items()
            if (name in stated or value != args.option_defaults.get(name))
            and (name not in OWN or name in own)
        },
    )


def source_of(args: argparse.Namespace) -> dict[str, Any]:
    """Return the origin of the terrain, as a summary states it."""
    from pathgene.host.inputs import exists

    path = Path(args.terrain)
    from pathgene.host.terrain.stated import Stated

    return {
        "source": os.path.realpath(path) if exists(path) else args.terrain,
        "fill_voids": args.fill_voids,
        "cell_m": args.cell and list(args.cell),
        **Stated.of(vars(args)).to_dict(),
    }


def own_options(args: argparse.Namespace, *planners: str) -> dict[str, Any]:
    """Return the given options that one of ``planners`` has; note options that none has."""
    given = {name: getattr(args, name) for name in OWN if getattr(args, name) is not None}
    ignored = ignored_options(given, *planners)
    names = " or ".join(dict.fromkeys(planners))
    for name in ignored:
        note(f"{NAMED[name].flag} means nothing to {names} and is ignored.")
    return {name: value for name, value in given.items() if name not in ignored}


def ignored_options(values: Mapping[str, Any], *planners: str) -> list[str]:
    """Return the names of the options in ``values`` that none of ``planners`` has, sorted."""
    given = {name for name in OWN if values.get(name) is not None}
    # An unknown name is reported when the planner is made.
    known = [PLANNERS[name].options if name in PLANNERS else given for name in planners]
    return sorted(given.difference(*known))
