"""Arguments of ``pathgene auv``."""

from __future__ import annotations

from pathgene.host.auv import PLANNERS
from pathgene.host.cli.arguments.base import Commands, add_command
from pathgene.host.planners import OPTIONS


__all__ = ["add_auv"]


def add_auv(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
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
        choices=PLANNERS,
        default=PLANNERS[0],
        help="the planner of the paper, or the conventional GA that it is compared with "
        "(default %(default)s)",
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
        "--as-paper",
        action="store_true",
        help="read the seabed as in the paper, at 21 samples per segment, even in the spline's "
        "parameter, which step over hills; without it the samples are even in arc length, and as "
        "many as it takes",
    )
    parser.add_argument(
        "--samples",
        type=int,
        metavar="N",
        help="read the seabed in the paper's way at N samples per segment (--as-paper: 21)",
    )
    parser.add_argument(
        "--length",
        choices=("2d", "3d"),
        default="2d",
        help="horizontal length, or length along the seabed (default %(default)s)",
    )
    parser.add_argument(
        "--generations", type=int, metavar="N", help="number of generations (default 100)"
    )
    parser.add_argument(
        "--seed",
        type=int,
        metavar="N",
        default=0,
        help="seed of all random draws; the same seed gives the same result (default %(default)s)",
    )
    parser.add_argument(
        "--out", metavar="DIR", default="out", help="directory to write to (default %(default)s)"
    )
