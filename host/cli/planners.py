"""``pathgene planners``."""

from __future__ import annotations

import argparse

from pathgene.host.cli.output import print_json, print_table
from pathgene.host.planners import OPTIONS, PLANNERS


__all__ = ["run"]


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
                    "options": {name: OPTIONS[name].meaning for name in entry.options},
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
                        " ".join(f"--{name.replace('_', '-')}" for name in entry.options),
                    )
                    for name, entry in PLANNERS.items()
                ),
            ]
        )
    return 0
