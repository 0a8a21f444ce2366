"""The parser of the command line. Imports nothing heavy, so that ``--help`` answers quickly."""

from __future__ import annotations

import argparse
import importlib
from importlib import metadata

from pathgene.host.cli.arguments import Parser


__all__ = ["build_parser"]

#: The commands, in the order of the help; each is a module of this folder.
_COMMANDS = (
    "plan",
    "desk",
    "problem",
    "batch",
    "compare",
    "check",
    "mend",
    "diagnose",
    "fly",
    "export",
    "upload",
    "feasible",
    "board",
    "terrain",
    "planners",
    "auv",
    "verilog",
)


def build_parser(command: str | None = None) -> argparse.ArgumentParser:
    """Return the parser of ``pathgene``; its ``command`` is the function to run.

    Parameters
    ----------
    command : str, optional
        Name of the command that the arguments begin with. The parser knows and imports only this
        command; it knows all commands if the name is None or unknown.
    """
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
    for name in [command] if command in _COMMANDS else _COMMANDS:
        importlib.import_module(f"pathgene.host.cli.{name}").add(commands)
    return parser


def _version() -> str:
    try:
        return metadata.version("pathgene")
    except metadata.PackageNotFoundError:
        return "(not installed)"
