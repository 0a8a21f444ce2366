"""``pathgene terrain``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from pathgene.host.cli.output import print_json, print_pairs, print_table
from pathgene.host.cli.problem import load_terrain
from pathgene.host.errors import InputError
from pathgene.host.files.output import output_file, prepare_file
from pathgene.host.report.summary import finite
from pathgene.host.terrain import embedded, synthetic
from pathgene.host.terrain import info as describe


__all__ = ["info", "list_embedded", "synth"]


def list_embedded(args: argparse.Namespace) -> int:
    """List the embedded terrains."""
    entries = embedded.describe()
    if args.json:
        print_json([entry._asdict() for entry in entries])
    else:
        print_table([entries[0]._fields, *entries])
    return 0


def info(args: argparse.Namespace) -> int:
    """Describe a terrain."""
    report = finite(describe(load_terrain(args)))
    if args.json:
        print_json(report)
    else:
        _print(report)
    return 0


def synth(args: argparse.Namespace) -> int:
    """Make a synthetic terrain and describe it."""
    if args.seed < 0:
        raise InputError(f"The seed must be 0 or more, not {args.seed}.")
    file = Path(args.out)
    if file.suffix != ".npz":
        raise InputError(f"The file of a terrain must end in .npz, unlike {args.out!r}.")
    prepare_file(file)
    terrain = getattr(synthetic, args.kind.replace("-", "_"))(args.seed)
    with output_file(file) as binary:
        terrain.save_npz(binary, np.zeros(terrain.shape, dtype=bool))
    report = {"file": str(file), **finite(describe(terrain))}
    if args.json:
        print_json(report)
    else:
        print_pairs([("file", str(file))])
        _print(report)
    return 0


def _print(report: dict[str, Any]) -> None:
    elevation = report["elevation_m"]
    rows, columns = report["shape"]
    corners = report["corners"] or {}
    print_pairs(
        [
            ("name", report["name"]),
            ("nodes", f"{rows} from south to north, {columns} from west to east"),
            ("cell", f"{report['dx_m']:g} x {report['dy_m']:g} m"),
            ("extent", f"{report['width_m']:g} x {report['height_m']:g} m"),
            (
                "heights",
                f"{elevation['min']:g} to {elevation['max']:g} m, mean {elevation['mean']:.1f} m",
            ),
            ("voids", f"{report['voids']} nodes, {report['void_share']:.2%}"),
            ("CRS", report["crs"] or "none"),
            *((f"corner {name}", f"{lat:.6f}, {lon:.6f}") for name, (lat, lon) in corners.items()),
            ("source", report["source"]),
        ]
    )
