"""Options of a search: when it stops, its population, and the options of single planners."""

from __future__ import annotations

import argparse

from host.cli.arguments.base import Parser
from host.planners import OPTIONS, PLANNERS


__all__ = ["add_own_options", "add_search"]


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


def add_own_options(parser: Parser) -> None:
    """Add the options that only some planners have."""
    group = parser.add_argument_group("options of some planners")
    for name, option in OPTIONS.items():
        having = ", ".join(planner for planner, entry in PLANNERS.items() if name in entry.options)
        group.add_argument(
            f"--{name.replace('_', '-')}",
            type=option.type,
            metavar=option.metavar,
            choices=option.choices or None,
            help=f"{having}: {option.meaning}",
        )
