"""``pathgene verilog``."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path

from pathgene.hdl.config import Config
from pathgene.hdl.verilog import TOPS, export
from pathgene.host.cli.output import print_json, print_pairs
from pathgene.host.errors import InputError
from pathgene.host.files.output import output_file, prepare_file
from pathgene.host.old_words import current_setting, current_top


__all__ = ["run"]


def run(args: argparse.Namespace) -> int:
    """Write the Verilog of a top."""
    top = current_top(args.top)
    if top not in TOPS:
        raise InputError(f"There is no top {top!r}; the tops are {', '.join(TOPS)}.")
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
    """Convert an integer; the configuration checks other texts."""
    try:
        return int(text, 0)
    except ValueError:
        return text
