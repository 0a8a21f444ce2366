"""``pathgene terrain``."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pathgene.host.cli.arguments import Commands, add_command, add_command_group, add_options
from pathgene.host.cli.output import print_json, print_pairs, print_table
from pathgene.host.errors import InputError
from pathgene.host.files.output import output_file, prepare_file
from pathgene.host.options.table import NAMED


__all__ = ["add", "info", "list_embedded", "synth"]

# Characters of a reference system that is shown by its name.
_LONG = 20


def add(commands: Commands) -> None:
    """Add the command and its commands."""
    actions = add_command_group(
        commands, "terrain", "List, describe and make terrains", "pathgene terrain info tile.tif"
    )
    add_command(
        actions,
        "list",
        list_embedded,
        "List the embedded terrains",
        "pathgene terrain list --json",
    )
    describing = add_command(
        actions,
        "info",
        info,
        "Describe a terrain",
        "pathgene terrain info tile.tif --fill-voids",
    )
    describing.add_argument("terrain", metavar="FILE|NAME", help="as --terrain of pathgene plan")
    describing.add_argument("--fill-voids", action="store_true", help=NAMED["fill_voids"].described)
    add_options(
        describing,
        [
            NAMED[name]
            for name in ("max_cells", "cell", "water_level", "height_unit", "heights", "void")
        ],
    )
    making = add_command(
        actions,
        "synth",
        synth,
        "Make a synthetic terrain",
        "pathgene terrain synth canyon --seed 3 --out canyon3.npz",
    )
    making.add_argument(
        "kind",
        metavar="KIND",
        choices=("canyon", "river", "large-canyon"),
        help="canyon, river or large-canyon",
    )
    making.add_argument(
        "--seed",
        type=int,
        metavar="N",
        default=0,
        help="seed of the terrain; the same seed gives the same terrain (default %(default)s)",
    )
    making.add_argument("--out", metavar="FILE", required=True, help=".npz file to write")


def list_embedded(args: argparse.Namespace) -> int:
    """List the embedded terrains."""
    from pathgene.host.terrain import embedded

    entries = embedded.describe()
    if args.json:
        print_json([entry._asdict() for entry in entries])
    else:
        print_table([entries[0]._fields, *entries])
    return 0


def info(args: argparse.Namespace) -> int:
    """Describe a terrain."""
    from pathgene.host.mission.build import terrain_of
    from pathgene.host.report.summary import finite
    from pathgene.host.terrain import info as describe

    report = finite(describe(terrain_of(vars(args))))
    if args.json:
        print_json(report)
    else:
        _print(report)
    return 0


def synth(args: argparse.Namespace) -> int:
    """Make a synthetic terrain and describe it."""
    import numpy as np

    from pathgene.host.report.summary import finite
    from pathgene.host.terrain import info as describe
    from pathgene.host.terrain import synthetic

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
            ("CRS", _short(report["crs"])),
            *_read(report["read"]),
            *((f"corner {name}", f"{lat:.6f}, {lon:.6f}") for name, (lat, lon) in corners.items()),
            ("source", report["source"]),
            *((each["grade"], each["text"]) for each in report["read"]["remarks"]),
        ]
    )


def _read(read: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the known facts that were read from the file."""
    heights, cells, projection = read["heights"], read["cell_m"], read["projection"]
    yield "driver", read["driver"]
    declared = read["voids"]["declared"]
    yield "declared void", "none" if declared is None else f"{declared:g}"
    if "middle" in cells:
        corners = ", ".join("{:g} x {:g}".format(*cells[name]) for name in ("sw", "se", "nw", "ne"))
        middle = "{:g} x {:g}".format(*cells["middle"])
        yield "true cell", f"{middle} m at the middle; {corners} m at the corners"
        done = "warped" if projection["is_warped"] else "kept"
        yield "projection", f"{_short(projection['file'])}, {done}"
        yield "grid north", f"{read['grid_north_deg']:g} degrees clockwise from true north"
    yield "unit", f"{heights['unit']} ({heights['unit_from']})"
    yield "datum", f"{heights['datum']} ({heights['datum_from']})"
    yield "below 0 m", f"{heights['share_below_0']:.2%} of the heights"
    level = read["water_level_m"]
    yield "water", "none" if level is None else f"at {level:g} m"


def _short(crs: str | None) -> str:
    """Return a reference system on a line: its code, or the name in its definition."""
    if crs is None:
        return "none"
    if len(crs) < _LONG or '"' not in crs:
        return crs
    name = crs.split('"')[1]
    return "local metres, transverse Mercator" if name == "unknown" else name
