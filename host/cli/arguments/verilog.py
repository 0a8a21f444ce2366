"""Arguments of ``pathgene verilog``."""

from __future__ import annotations

import argparse

from pathgene.host.cli.arguments.base import Commands, add_command


__all__ = ["add_verilog"]


def add_verilog(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "verilog",
        "verilog:run",
        "Write the Verilog of the chip or of one of its units",
        "pathgene verilog --top chip --out chip.v --set max_waypoints=20",
    )
    parser.add_argument(
        "--top", metavar="NAME", required=True, help="chip, ga_core, or the name of a unit"
    )
    parser.add_argument("--out", metavar="FILE", required=True, help="file to write")
    parser.add_argument(
        "--set",
        type=_setting,
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="set a field of the configuration; may be repeated",
    )


def _setting(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not (key and equals):
        raise argparse.ArgumentTypeError(f"must be KEY=VALUE, not {text!r}")
    return key, value
