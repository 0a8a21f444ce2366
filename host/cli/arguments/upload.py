"""Arguments of ``pathgene upload``."""

from __future__ import annotations

from pathgene.host.cli.arguments.base import Commands, add_command, numbers


__all__ = ["add_upload"]


def add_upload(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "upload",
        "upload:run",
        "Upload a planned path and its fences to an autopilot",
        "pathgene upload out/summary.json --to udpout:127.0.0.1:14550",
        notes="Mission and fence are read back and compared. If anything differs, the autopilot "
        "gets its earlier mission and fence back, and the exit status is 1. Needs the extra "
        "pathgene[mavlink].",
    )
    parser.add_argument(
        "file",
        metavar="SUMMARY|FILE.plan",
        help="summary.json of pathgene plan, or a .plan file with altitudes above mean sea level",
    )
    parser.add_argument(
        "--to",
        metavar="ADDRESS",
        required=True,
        help="udpout:HOST:PORT, udpin:HOST:PORT, tcp:HOST:PORT or a serial device",
    )
    parser.add_argument(
        "--baud",
        type=int,
        metavar="N",
        default=57600,
        help="speed of a serial device (default %(default)s)",
    )
    parser.add_argument(
        "--autopilot",
        choices=("ardupilot", "px4"),
        help="kind of the autopilot (default: as its heartbeat says); ArduPilot takes item 0 as "
        "home",
    )
    parser.add_argument(
        "--timeout",
        type=float,
        metavar="S",
        default=10.0,
        help="maximum wait for the autopilot's heartbeat, seconds (default %(default)g)",
    )
    parser.add_argument(
        "--origin",
        type=numbers("LAT,LON"),
        metavar="LAT,LON",
        help="place of the south-west node of a terrain that states none, north up, in WGS84 "
        "degrees",
    )
    parser.add_argument(
        "--infeasible", action="store_true", help="upload a path that is not feasible, too"
    )
