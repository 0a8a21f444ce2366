"""``pathgene planners``."""

from __future__ import annotations

import argparse

from pathgene.host.cli.arguments import Commands, add_command
from pathgene.host.cli.output import print_json, print_table
from pathgene.host.options.table import NAMED
from pathgene.host.planners import PLANNERS


__all__ = ["add", "run"]


def add(commands: Commands) -> None:
    """Add the command."""
    add_command(
        commands,
        "planners",
        run,
        "List the planners and their papers",
        "pathgene planners --json",
    )


def run(args: argparse.Namespace) -> int:
    """List the planners."""
    if args.json:
        print_json(
            [
                {
                    "name": name,
                    "description": entry.description,
                    "paper": entry.paper,
                    "generations": entry.generations,
                    "engines": list(entry.engines),
                    "options": {name: NAMED[name].described for name in entry.options},
                }
                for name, entry in PLANNERS.items()
            ]
        )
    else:
        print_table(
            [
                ("name", "description", "paper", "engines", "options"),
                *(
                    (
                        name,
                        entry.description,
                        entry.paper,
                        " ".join(entry.engines),
                        " ".join(NAMED[name].flag for name in entry.options),
                    )
                    for name, entry in PLANNERS.items()
                ),
            ]
        )
    return 0
