"""Options of the rules of safe flight."""

from __future__ import annotations

import argparse

from pathgene.host.cli.arguments.base import Parser


__all__ = ["add_as_paper", "add_rules"]


def add_rules(parser: Parser) -> argparse._ArgumentGroup:
    """Add the options; None is the default of each, so that a file may supply them."""
    group = parser.add_argument_group("rules of safe flight")
    for name, metavar, meaning in (
        ("clearance", "M", "least height over the ground in metres (default 30)"),
        ("corridor", "M", "half the width of the strip that keeps the clearance (default 25)"),
        ("ceiling", "M", "highest altitude above the datum (default none)"),
        ("ceiling-agl", "M", "greatest height over the ground (default none)"),
        ("zone-margin", "M", "metres from no-fly zones, also above and below (default 25)"),
        ("reserve", "PERCENT", "share of the fuel to be left at the goal (default 10)"),
        ("start-heading", "DEG", "heading at the start, degrees from north (default any)"),
        ("goal-heading", "DEG", "heading at the goal, degrees from north (default any)"),
    ):
        group.add_argument(f"--{name}", type=float, metavar=metavar, help=meaning)
    add_as_paper(group)
    return group


def add_as_paper(group: argparse._ArgumentGroup) -> None:
    """Add the option that leaves all rules out."""
    group.add_argument(
        "--as-paper",
        action=argparse.BooleanOptionalAction,
        default=False,
        help="no rules: the evaluation of the papers alone, as in version 0.1",
    )
