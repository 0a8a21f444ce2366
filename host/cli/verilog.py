"""``pathgene verilog``."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path

from pathgene.host.cli.arguments import Commands, add_command
from pathgene.host.cli.output import note_start, print_json, print_pairs
from pathgene.host.errors import InputError
from pathgene.host.files.output import output_file, prepare_file
from pathgene.host.old_words import current_setting, current_top
from pathgene.host.suggestion import did_you_mean


__all__ = ["add", "run"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "verilog",
        run,
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


def run(args: argparse.Namespace) -> int:
    """Write the Verilog of a top-level design."""
    note_start("Elaborating the design.")
    from pathgene.hdl.config import Config
    from pathgene.hdl.verilog import TOPS, export

    top = current_top(args.top)
    if top not in TOPS:
        raise InputError(
            f"There is no top {top!r}{did_you_mean(top, TOPS)}; the tops are {', '.join(TOPS)}."
        )
    fields = [field.name for field in dataclasses.fields(Config)]
    settings = [current_setting(*setting) for setting in args.set]
    for key, _ in settings:
        if key not in fields:
            raise InputError(
                f"The configuration has no field {key!r}; the fields are {', '.join(fields)}."
            )
    try:
        config = Config().replace(**{key: _value(value) for key, value in settings})
    except (TypeError, ValueError) as error:
        raise InputError(f"A --set is wrong: {error}.") from None
    file = Path(args.out)
    prepare_file(file)
    text = export(top, config).encode()
    with output_file(file) as binary:
        binary.write(text)
    if args.json:
        print_json(
            {
                "top": top,
                "file": str(file),
                "bytes": len(text),
                "build_id": f"{config.build_id:08x}",
            }
        )
    else:
        print_pairs(
            [
                ("top", top),
                ("file", f"{file} ({len(text)} bytes)"),
                ("build id", f"{config.build_id:08x}"),
            ]
        )
    return 0


def _value(text: str) -> int | str:
    """Convert an integer; any other text is left to the configuration to check."""
    try:
        return int(text, 0)
    except ValueError:
        return text
