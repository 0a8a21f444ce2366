"""Options of a problem: the terrain, the start, the goal, the no-fly zones and the aircraft."""

from __future__ import annotations

from host.cli.arguments.base import Parser, cell_sides, numbers
from host.cli.arguments.rules import add_rules


__all__ = ["add_problem"]


def add_problem(parser: Parser, *, ends_required: bool) -> None:
    """Add the options of a problem.

    Parameters
    ----------
    parser : Parser
        The command.
    ends_required : bool
        Require terrain, start and goal. Otherwise a file supplies them.
    """
    need = "required, or its -geo twin" if ends_required else "must be the path's own end"
    group = parser.add_argument_group("problem")
    group.add_argument(
        "--terrain",
        metavar="FILE|NAME",
        required=ends_required,
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
        "--agl",
        action="store_true",
        help="altitudes of start and goal are heights above the ground",
    )
    group.add_argument(
        "--nofly",
        metavar="FILE",
        action="append",
        default=[],
        help="no-fly zones: GeoJSON of polygons, or of points with radius_m; may be repeated",
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
        "--wind", type=numbers("VX,VY"), metavar="VX,VY", help="constant wind in m/s (default 0,0)"
    )
    group.add_argument(
        "--fill-voids",
        action="store_true",
        help="interpolate cells without data; by default they are impassable",
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
