"""The parser of the command line. Imports nothing heavy, so that ``--help`` answers at once."""

from __future__ import annotations

import argparse
from importlib import metadata

from pathgene.host.cli import (
    auv,
    batch,
    board,
    check,
    compare,
    desk,
    diagnose,
    export,
    feasible,
    fly,
    plan,
    planners,
    problem,
    terrain,
    upload,
    verilog,
)
from pathgene.host.cli.arguments import Parser


__all__ = ["build_parser"]

#: The commands, in the order of the help.
_COMMANDS = (
    plan,
    desk,
    problem,
    batch,
    compare,
    check,
    diagnose,
    fly,
    export,
    upload,
    feasible,
    board,
    terrain,
    planners,
    auv,
    verilog,
)


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of ``pathgene``; its ``command`` is the function to run."""
    parser = Parser(
        prog="pathgene",
        allow_abbrev=False,
        description="Plan UAV paths over terrain with a genetic algorithm in hardware.",
        epilog="Example: pathgene plan --terrain canyon --agl "
        "--start 300,300,60 --goal 4700,4600,60 --out out",
    )
    parser.add_argument("--version", action="version", version=f"pathgene {_version()}")
    parser.set_defaults(command=None)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")
    for command in _COMMANDS:
        command.add(commands)
    return parser


def _version() -> str:
    try:
        return metadata.version("pathgene")
    except metadata.PackageNotFoundError:
        return "(not installed)"
