"""Arguments of ``pathgene fly``."""

from __future__ import annotations

from pathgene.host.cli.arguments.base import Commands, add_command, numbers
from pathgene.host.planners.options import DEFAULT_BOARD


__all__ = ["add_fly"]


def add_fly(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "fly",
        "fly:run",
        "Fly a planned path in a flight-dynamics model and judge the flight",
        "pathgene fly out/plan/summary.json --gusts light --popup ahead:1500,300@40",
        usage="[OPTIONS] SUMMARY",
        notes="It needs the extra pathgene[fly]. The exit status is 1 where the flight breaks the "
        "ground, a zone or half the clearance, all as the summary states them; a plan made with "
        "--as-paper is judged without a clearance. With --popup or --scenario the planner plans "
        "anew in flight, in simulated time: chip cycles, bits on the line, and the processor's "
        "seconds.",
    )
    parser.add_argument("summary", metavar="SUMMARY", help="summary.json of a plan")
    parser.add_argument(
        "--aircraft",
        metavar="NAME",
        help="silver-fox, c172p or j3cub (default: the one planned for); another than the one "
        "planned for flies with its own speed and limits",
    )
    parser.add_argument(
        "--wind",
        metavar="VX,VY",
        type=numbers("VX,VY"),
        help="wind in m/s, x and y (default: the one planned for)",
    )
    parser.add_argument(
        "--gusts",
        metavar="NAME",
        default="none",
        help="Dryden turbulence: none, light, moderate or severe (default none)",
    )
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="seed of the turbulence (default 0)"
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="folder of flight.json, flight.png and flight.gif (default: that of SUMMARY)",
    )
    group = parser.add_argument_group("replanning in flight")
    group.add_argument(
        "--popup",
        metavar="ZONE@T",
        action="append",
        default=[],
        help="zone that appears T seconds after the start: X,Y,R; ahead:M,R on the path, M metres "
        "ahead of the aircraft; goal:R; aircraft:R; or a file of zones; may be repeated",
    )
    group.add_argument(
        "--scenario", metavar="FILE.toml", help="what happens during the flight; see docs"
    )
    group.add_argument(
        "--planner",
        metavar="NAME",
        help="planner that plans during the flight (default: the one of the board; ga-chip)",
    )
    group.add_argument(
        "--board", metavar="URL", default=DEFAULT_BOARD, help="its board (default %(default)s)"
    )
    group.add_argument(
        "--planner-seconds",
        metavar="S",
        type=float,
        help="time of a plan on the processor (default: measured before the flight)",
    )
