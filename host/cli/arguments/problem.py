"""Options of a problem: the terrain, the start, the goal, the no-fly zones and the aircraft."""

from __future__ import annotations

import argparse

from pathgene.host.cli.arguments.base import Parser, cell_sides, numbers
from pathgene.host.cli.arguments.rules import add_rules
from pathgene.host.formats.registry import zone_files


__all__ = ["add_problem"]


def add_problem(parser: Parser, *, of_path: bool = False) -> None:
    """Add the options of a problem.

    Parameters
    ----------
    parser : Parser
        The command.
    of_path : bool
        The problem is that of a given path, which has its own ends.
    """
    need = "must be the path's own end" if of_path else "required, or its -geo twin"
    group = parser.add_argument_group("problem")
    group.add_argument(
        "--terrain",
        metavar="FILE|NAME",
        help="GeoTIFF, .hgt, any other raster that rasterio opens, .npy, .npz, or a name from "
        "'pathgene terrain list'",
    )
    group.add_argument(
        "--origin",
        type=numbers("LAT,LON"),
        metavar="LAT,LON",
        help="place of the south-west node of a terrain that states none, north up, in WGS84 "
        "degrees",
    )
    for end in ("start", "goal"):
        either = group.add_mutually_exclusive_group()
        either.add_argument(
            f"--{end}",
            type=numbers("X,Y,Z"),
            metavar="X,Y,Z",
            help=f"metres east and north of the south-west node, and altitude ({need})",
        )
        either.add_argument(
            f"--{end}-geo",
            type=numbers("LAT,LON,ALT"),
            metavar="LAT,LON,ALT",
            help="latitude and longitude in WGS84 degrees, and altitude in metres",
        )
    group.add_argument(
        "--via",
        type=numbers("X,Y,Z"),
        metavar="X,Y,Z",
        action="append",
        default=[],
        help="point to pass between start and goal; repeated, the points are passed in order",
    )
    group.add_argument(
        "--via-geo",
        type=numbers("LAT,LON,ALT"),
        metavar="LAT,LON,ALT",
        action="append",
        default=[],
        help="the same in WGS84 degrees",
    )
    group.add_argument(
        "--return",
        dest="return_to_start",
        action=argparse.BooleanOptionalAction,
        default=False,
        help="fly back from the goal to the start",
    )
    group.add_argument(
        "--agl",
        action=argparse.BooleanOptionalAction,
        default=False,
        help="altitudes of start, goal and via points are heights above the ground",
    )
    group.add_argument(
        "--nofly",
        metavar="FILE",
        action="append",
        default=[],
        help=f"no-fly zones: {zone_files()}; may be repeated",
    )
    group.add_argument(
        "--nofly-circle",
        type=numbers("X,Y,R"),
        metavar="X,Y,R",
        action="append",
        default=[],
        help="circular no-fly zone, centre and radius in metres; may be repeated",
    )
    group.add_argument(
        "--uav",
        metavar="NAME|FILE",
        help="aircraft: a built-in one or a .toml file (default silver-fox)",
    )
    group.add_argument(
        "--wind",
        type=numbers("VX,VY"),
        metavar="VX,VY",
        help="constant wind towards the east and towards the north, m/s (default 0,0)",
    )
    group.add_argument(
        "--fill-voids",
        action=argparse.BooleanOptionalAction,
        default=False,
        help="interpolate cells without data; by default they are impassable",
    )
    group.add_argument(
        "--max-cells",
        type=int,
        metavar="N",
        help="most cells of a terrain that is read (default 25 million)",
    )
    group.add_argument(
        "--ds",
        type=float,
        metavar="M",
        help="sampling step in metres (default half the shorter side of a cell)",
    )
    group.add_argument(
        "--cell",
        type=cell_sides,
        metavar="DX[,DY]",
        help="sides of a cell of a .npy terrain in metres",
    )
    add_rules(parser)
