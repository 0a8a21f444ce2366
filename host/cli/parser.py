"""What every command accepts. Imports nothing heavy: ``--help`` answers at once."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from importlib import metadata
from typing import NoReturn

from host.auv import PLANNERS as AUV_PLANNERS
from host.compare import LOCAL
from host.device.checker_modes import MODES
from host.errors import InputError
from host.planners import DEFAULT, OPTIONS, PLANNERS


__all__ = ["build_parser"]


class _Parser(argparse.ArgumentParser):
    """An argument parser that raises :class:`InputError` and keeps no abbreviated options."""

    def error(self, message: str) -> NoReturn:
        """Raise the message of argparse as one sentence."""
        raise InputError(f"{message[:1].upper()}{message[1:]}; see {self.prog} --help.")


def _numbers(names: str) -> Callable[[str], tuple[float, ...]]:
    """Return a converter of as many comma-separated numbers as ``names`` has."""

    def convert(text: str) -> tuple[float, ...]:
        parts = text.split(",")
        try:
            values = tuple(map(float, parts))
        except ValueError:
            values = ()
        if len(values) != len(names.split(",")):
            raise argparse.ArgumentTypeError(f"must be numbers {names}, not {text!r}")
        return values

    return convert


def _cell(text: str) -> tuple[float, float]:
    dx, *dy = _numbers("DX,DY" if "," in text else "DX")(text)
    return dx, dy[0] if dy else dx


def _setting(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not (key and equals):
        raise argparse.ArgumentTypeError(f"must be KEY=VALUE, not {text!r}")
    return key, value


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of ``pathgene``; its ``command`` is the ``module:function`` to run."""
    parser = _Parser(
        prog="pathgene",
        allow_abbrev=False,
        description="Plan UAV paths over terrain with a genetic algorithm in hardware.",
        epilog="Example: pathgene plan --terrain canyon --agl "
        "--start 300,300,60 --goal 4700,4600,60 --out out",
    )
    parser.add_argument("--version", action="version", version=f"pathgene {_version()}")
    parser.set_defaults(command=None)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")
    _add_plan(commands)
    _add_compare(commands)
    _add_check(commands)
    _add_feasible(commands)
    _add_board(commands)
    _add_terrain(commands)
    _add_planners(commands)
    _add_auv(commands)
    _add_verilog(commands)
    return parser


def _version() -> str:
    try:
        return metadata.version("pathgene")
    except metadata.PackageNotFoundError:
        return "(not installed)"


def _command(
    commands: argparse._SubParsersAction[_Parser],
    name: str,
    target: str,
    summary: str,
    example: str,
) -> _Parser:
    parser: _Parser = commands.add_parser(
        name,
        allow_abbrev=False,
        help=summary,
        description=f"{summary}.",
        epilog=f"Example: {example}",
    )
    parser.set_defaults(command=target)
    parser.add_argument("--json", action="store_true", help="print JSON on standard output")
    parser.add_argument("--debug", action="store_true", help="show a traceback with an error")
    return parser


def _add_problem(parser: _Parser, *, ends_required: bool) -> None:
    """Add the options that say what is flown over, with what, and around what."""
    need = "required, or its -geo twin" if ends_required else "must be the path's own end"
    group = parser.add_argument_group("problem")
    group.add_argument(
        "--terrain",
        metavar="FILE|NAME",
        required=ends_required,
        help="GeoTIFF, .hgt, anything rasterio opens, .npy, .npz, or a name of "
        "'pathgene terrain list'",
    )
    for end in ("start", "goal"):
        either = group.add_mutually_exclusive_group()
        either.add_argument(
            f"--{end}",
            type=_numbers("X,Y,Z"),
            metavar="X,Y,Z",
            help=f"metres from the south-west node, altitude ({need})",
        )
        either.add_argument(
            f"--{end}-geo",
            type=_numbers("LAT,LON,ALT"),
            metavar="LAT,LON,ALT",
            help="WGS84 degrees and altitude in metres",
        )
    group.add_argument(
        "--agl",
        action="store_true",
        help="the altitudes of start and goal are heights above the ground",
    )
    group.add_argument(
        "--nofly",
        metavar="FILE",
        action="append",
        default=[],
        help="GeoJSON of polygons, or points with radius_m",
    )
    group.add_argument(
        "--nofly-circle",
        type=_numbers("X,Y,R"),
        metavar="X,Y,R",
        action="append",
        default=[],
        help="circle in metres; may be repeated",
    )
    group.add_argument(
        "--uav", metavar="NAME|FILE", help="aircraft, or a .toml file of one (default silver-fox)"
    )
    group.add_argument(
        "--wind", type=_numbers("VX,VY"), metavar="VX,VY", help="constant wind in m/s (default 0,0)"
    )
    group.add_argument(
        "--fill-voids",
        action="store_true",
        help="interpolate cells without data, which are else impassable",
    )
    group.add_argument(
        "--ds",
        type=float,
        metavar="M",
        help="sampling step in metres (default half the smaller side of a cell)",
    )
    group.add_argument(
        "--cell", type=_cell, metavar="DX[,DY]", help="sides of a cell of a .npy terrain in metres"
    )


def _add_plan(commands: argparse._SubParsersAction[_Parser]) -> None:
    parser = _command(
        commands,
        "plan",
        "plan:run",
        "Plan a path and write it with a summary and a picture",
        "pathgene plan --terrain tile.tif --start 1200,1200,100 --goal 14000,14000,100 --agl "
        "--nofly-circle 7000,7000,900 --board sim: --out out",
    )
    _add_problem(parser, ends_required=True)
    group = parser.add_argument_group("planning")
    group.add_argument(
        "--planner",
        metavar="NAME",
        default=DEFAULT,
        help=f"one of {', '.join(PLANNERS)} (default %(default)s)",
    )
    _add_search(group)
    group.add_argument(
        "--seed",
        type=int,
        metavar="N",
        default=0,
        help="same seed, same result (default %(default)s)",
    )
    group.add_argument(
        "--out", metavar="DIR", default="out", help="where the files go (default %(default)s)"
    )
    group.add_argument(
        "--no-picture",
        dest="picture",
        action="store_false",
        help="do not draw path.png, and remove one of an earlier run",
    )
    _add_own_options(parser)


def _add_search(group: argparse._ArgumentGroup) -> None:
    """Add the stop criteria and the population."""
    defaults = ", ".join(f"{name} {entry.generations}" for name, entry in PLANNERS.items())
    group.add_argument(
        "--generations", type=int, metavar="N", help=f"most generations (default {defaults})"
    )
    group.add_argument("--time-limit", type=float, metavar="S", help="most seconds of planning")
    group.add_argument(
        "--target-fitness", type=float, metavar="F", help="stop when the best fitness is as good"
    )
    group.add_argument(
        "--population",
        type=int,
        metavar="N",
        help="paths in the population (default the planner's)",
    )


def _add_own_options(parser: _Parser) -> None:
    """Add the options that some planners have, and others not."""
    group = parser.add_argument_group("options of some planners")
    for name, option in OPTIONS.items():
        having = ", ".join(planner for planner, entry in PLANNERS.items() if name in entry.options)
        group.add_argument(
            f"--{name.replace('_', '-')}",
            type=option.type,
            metavar=option.metavar,
            choices=option.choices or None,
            help=f"{having}: {option.meaning}",
        )


def _add_compare(commands: argparse._SubParsersAction[_Parser]) -> None:
    parser = _command(
        commands,
        "compare",
        "compare:run",
        "Compare planners over many seeds",
        "pathgene compare --planners ga-fpga,ga-pc,ga-pc:max_waypoints=8 --terrain tile.tif "
        "--start 1200,1200,100 --goal 14000,14000,100 --agl --runs 5 --generations 20 "
        "--out out/compare",
    )
    _add_problem(parser, ends_required=True)
    group = parser.add_argument_group("comparison")
    group.add_argument(
        "--planners",
        metavar="NAME[:KEY=VALUE]...,...",
        required=True,
        help=f"some of {', '.join(PLANNERS)}; each may be followed by options that "
        "it alone has, as ga-pc:max_waypoints=8:generations=500, and come "
        "again with others",
    )
    group.add_argument(
        "--runs",
        type=int,
        metavar="N",
        default=50,
        help="runs of each, with seeds one after the other (default %(default)s)",
    )
    group.add_argument(
        "--seed",
        type=int,
        metavar="N",
        default=0,
        help="seed of the first run (default %(default)s)",
    )
    group.add_argument(
        "--jobs",
        type=int,
        metavar="N",
        help="runs at a time, each in a process (default one per core)",
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS|local",
        nargs="?",
        const=LOCAL,
        help="hand the runs to the Dask cluster at this address, or (local, or no "
        "address) to one started here for them; needs the extra "
        "pathgene[cluster]",
    )
    group.add_argument(
        "--out",
        metavar="DIR",
        default="out/compare",
        help="where the files go; runs that are there already are not run again "
        "(default %(default)s)",
    )
    group = parser.add_argument_group("planning")
    _add_search(group)
    _add_own_options(parser)


def _add_check(commands: argparse._SubParsersAction[_Parser]) -> None:
    parser = _command(
        commands,
        "check",
        "check:run",
        "Evaluate a path that is given",
        "pathgene check --terrain tile.tif --path out/path.geojson --json",
    )
    parser.add_argument(
        "--path",
        metavar="FILE",
        required=True,
        help="GeoJSON, CSV with the header x,y,z, or a summary.json, which also "
        "says what is not given here",
    )
    _add_problem(parser, ends_required=False)


def _add_feasible(commands: argparse._SubParsersAction[_Parser]) -> None:
    parser = _command(
        commands,
        "feasible",
        "feasible:run",
        "Check a path against a map, as the chip does",
        "pathgene feasible --map canyon.npy --path path.csv --board sim: --mode parallel",
    )
    parser.add_argument(
        "--map",
        metavar="FILE",
        required=True,
        help=".npy of integers [y, x], row 0 the south: altitude steps, the top "
        "one no-fly; cells that a smaller map lacks are no-fly",
    )
    parser.add_argument(
        "--path",
        metavar="FILE",
        required=True,
        help="CSV with the header x,y,z of whole cells and altitude steps, the "
        "aircraft first, the goal last",
    )
    parser.add_argument(
        "--board",
        metavar="URL",
        default="model:",
        help="as for pathgene plan; model: and sim: are built for the mode (default %(default)s)",
    )
    parser.add_argument(
        "--mode",
        choices=tuple(MODES),
        help="two segments in the detailed map and the others in the coarse one, "
        "all in the detailed one, the same several cells a clock, or the "
        "same where the coarse map is hit (default the board's, two-tier "
        "for model: and sim:)",
    )
    parser.add_argument(
        "--count",
        action="store_true",
        help="walk the whole path and count colliding cells of each segment, "
        "terrain and no-fly apart",
    )


def _add_board(commands: argparse._SubParsersAction[_Parser]) -> None:
    board = commands.add_parser(
        "board",
        allow_abbrev=False,
        help="Serve a simulated board, or ask a board what it is",
        description="Serve a simulated board, or ask a board what it is.",
        epilog="Example: pathgene board info --board sim:",
    )
    actions = board.add_subparsers(title="commands", metavar="COMMAND", required=True)
    serve = _command(
        actions,
        "serve",
        "board:serve",
        "Serve a simulated board to any serial client",
        "pathgene board serve --board sim: --listen 127.0.0.1:5000",
    )
    serve.add_argument(
        "--board", metavar="URL", default="sim:", help="sim: with its options (default %(default)s)"
    )
    where = serve.add_mutually_exclusive_group()
    where.add_argument(
        "--listen",
        metavar="HOST:PORT",
        default="127.0.0.1:0",
        help="where to listen; port 0 takes a free one (default %(default)s)",
    )
    where.add_argument("--pty", action="store_true", help="serve a pseudo terminal instead")
    info = _command(
        actions,
        "info",
        "board:info",
        "Print what is at the other end of a link",
        "pathgene board info --board /dev/ttyUSB0 --json",
    )
    info.add_argument(
        "--board",
        metavar="URL",
        default="model:",
        help="as for pathgene plan (default %(default)s)",
    )


def _add_terrain(commands: argparse._SubParsersAction[_Parser]) -> None:
    terrain = commands.add_parser(
        "terrain",
        allow_abbrev=False,
        help="List, describe and make terrains",
        description="List, describe and make terrains.",
        epilog="Example: pathgene terrain info tile.tif",
    )
    actions = terrain.add_subparsers(title="commands", metavar="COMMAND", required=True)
    _command(
        actions,
        "list",
        "terrain:list_embedded",
        "List the embedded terrains",
        "pathgene terrain list --json",
    )
    info = _command(
        actions,
        "info",
        "terrain:info",
        "Describe a terrain",
        "pathgene terrain info tile.tif --fill-voids",
    )
    info.add_argument("terrain", metavar="FILE|NAME", help="as --terrain of pathgene plan")
    info.add_argument("--fill-voids", action="store_true", help="interpolate cells without data")
    info.add_argument(
        "--cell", type=_cell, metavar="DX[,DY]", help="sides of a cell of a .npy terrain in metres"
    )
    synth = _command(
        actions,
        "synth",
        "terrain:synth",
        "Make a synthetic terrain",
        "pathgene terrain synth canyon --seed 3 --out canyon3.npz",
    )
    synth.add_argument(
        "kind",
        metavar="KIND",
        choices=("canyon", "river", "large-canyon"),
        help="canyon, river or large-canyon",
    )
    synth.add_argument(
        "--seed",
        type=int,
        metavar="N",
        default=0,
        help="same seed, same terrain (default %(default)s)",
    )
    synth.add_argument("--out", metavar="FILE", required=True, help=".npz file to write")


def _add_planners(commands: argparse._SubParsersAction[_Parser]) -> None:
    _command(
        commands,
        "planners",
        "planners:run",
        "List the planners and their papers",
        "pathgene planners --json",
    )


def _add_auv(commands: argparse._SubParsersAction[_Parser]) -> None:
    parser = _command(
        commands,
        "auv",
        "auv:run",
        "Plan the path of an underwater vehicle, the problem of ga-dp",
        "pathgene auv --landscape 1 --planner ga-dp --seed 1 --out auv",
    )
    parser.add_argument(
        "--landscape", type=int, metavar="N", default=1, help="1 or 2 (default %(default)s)"
    )
    parser.add_argument(
        "--planner",
        choices=AUV_PLANNERS,
        default=AUV_PLANNERS[0],
        help="the proposed planner, or the conventional GA beside it (default %(default)s)",
    )
    for name in ("reading", "draws", "added_points"):
        option = OPTIONS[name]
        parser.add_argument(
            f"--{name.replace('_', '-')}",
            type=option.type,
            metavar=option.metavar,
            choices=option.choices or None,
            help=option.meaning,
        )
    parser.add_argument(
        "--samples",
        type=int,
        metavar="N",
        help="points of a segment at which the seabed is read (default 21)",
    )
    parser.add_argument(
        "--length",
        choices=("2d", "3d"),
        default="2d",
        help="horizontal length, or that over the seabed (default %(default)s)",
    )
    parser.add_argument("--generations", type=int, metavar="N", help="how many (default 100)")
    parser.add_argument(
        "--seed",
        type=int,
        metavar="N",
        default=0,
        help="same seed, same result (default %(default)s)",
    )
    parser.add_argument(
        "--out", metavar="DIR", default="out", help="where the files go (default %(default)s)"
    )


def _add_verilog(commands: argparse._SubParsersAction[_Parser]) -> None:
    parser = _command(
        commands,
        "verilog",
        "verilog:run",
        "Write the Verilog of the chip or of one of its units",
        "pathgene verilog --top planner --out planner.v --set max_waypoints=20",
    )
    parser.add_argument(
        "--top", metavar="NAME", required=True, help="planner, ga_core, or the name of a unit"
    )
    parser.add_argument("--out", metavar="FILE", required=True, help="file to write")
    parser.add_argument(
        "--set",
        type=_setting,
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="change a field of the configuration; may be repeated",
    )
