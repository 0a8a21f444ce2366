"""The parser of the command line. Imports nothing heavy, so that ``--help`` answers at once."""

from __future__ import annotations

import argparse
from importlib import metadata

from pathgene.host.cli.arguments.auv import add_auv
from pathgene.host.cli.arguments.base import Parser, add_command
from pathgene.host.cli.arguments.batch import add_batch
from pathgene.host.cli.arguments.board import add_board
from pathgene.host.cli.arguments.check import add_check
from pathgene.host.cli.arguments.compare import add_compare
from pathgene.host.cli.arguments.desk import add_desk
from pathgene.host.cli.arguments.diagnose import add_diagnose
from pathgene.host.cli.arguments.export import add_export
from pathgene.host.cli.arguments.feasible import add_feasible
from pathgene.host.cli.arguments.fly import add_fly
from pathgene.host.cli.arguments.plan import add_plan
from pathgene.host.cli.arguments.problem_files import add_problem_files
from pathgene.host.cli.arguments.terrain import add_terrain
from pathgene.host.cli.arguments.upload import add_upload
from pathgene.host.cli.arguments.verilog import add_verilog


__all__ = ["build_parser"]


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of ``pathgene``; its ``command`` is the ``module:function`` to run."""
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
    add_plan(commands)
    add_desk(commands)
    add_problem_files(commands)
    add_batch(commands)
    add_compare(commands)
    add_check(commands)
    add_diagnose(commands)
    add_fly(commands)
    add_export(commands)
    add_upload(commands)
    add_feasible(commands)
    add_board(commands)
    add_terrain(commands)
    add_command(
        commands,
        "planners",
        "planners:run",
        "List the planners and their papers",
        "pathgene planners --json",
    )
    add_auv(commands)
    add_verilog(commands)
    return parser


def _version() -> str:
    try:
        return metadata.version("pathgene")
    except metadata.PackageNotFoundError:
        return "(not installed)"
