"""Options of a search: when it stops, its population, and the options of single planners."""

from __future__ import annotations

import argparse

from pathgene.host.cli.arguments.base import Parser
from pathgene.host.planners import DEFAULT, OPTIONS, PLANNERS


__all__ = ["DEFAULT_PLANNER", "add_fallback", "add_own_options", "add_search"]

#: The rule of :func:`pathgene.host.planners.default.default_planner` for users.
DEFAULT_PLANNER = f"default {DEFAULT}, on a board with the paper core ga-fpga"


def add_search(group: argparse._ArgumentGroup) -> None:
    """Add the stop criteria and the size of the population."""
    defaults = ", ".join(f"{name} {entry.generations}" for name, entry in PLANNERS.items())
    group.add_argument(
        "--generations", type=int, metavar="N", help=f"maximum generations (default {defaults})"
    )
    group.add_argument(
        "--time-limit", type=float, metavar="S", help="maximum planning time in seconds"
    )
    group.add_argument(
        "--target-fitness",
        type=float,
        metavar="F",
        help="stop when the best fitness reaches F",
    )
    group.add_argument(
        "--population",
        type=int,
        metavar="N",
        help="paths in the population (default depends on the planner)",
    )


def add_fallback(group: argparse._ArgumentGroup) -> None:
    """Add the choice of what searches where the planner finds no feasible path."""
    group.add_argument(
        "--fallback",
        choices=("astar", "none"),
        default="astar",
        help="astar, and then fpa-2opt, search where the planner finds no feasible path (default "
        "%(default)s; none with --as-paper)",
    )


def add_own_options(parser: Parser) -> None:
    """Add the options that only some planners have, those of the same planners together."""
    having = {
        name: tuple(planner for planner, entry in PLANNERS.items() if name in entry.options)
        for name in OPTIONS
    }
    groups: dict[tuple[str, ...], argparse._ArgumentGroup] = {}
    for name in sorted(OPTIONS, key=lambda name: _place(having[name])):
        planners = having[name]
        if planners not in groups:
            groups[planners] = parser.add_argument_group(f"options of {_listed(planners)}")
        option = OPTIONS[name]
        groups[planners].add_argument(
            f"--{name.replace('_', '-')}",
            type=option.type,
            metavar=option.metavar,
            choices=option.choices or None,
            help=option.meaning,
        )


def _place(planners: tuple[str, ...]) -> tuple[int, ...]:
    """Return the place of a group of options: by its planners in the order of the registry."""
    return tuple(map(list(PLANNERS).index, planners))


def _listed(names: tuple[str, ...]) -> str:
    *most, last = names
    return f"{', '.join(most)} and {last}" if most else last
