"""Arguments of ``pathgene fly``."""

from __future__ import annotations

from host.cli.arguments.base import Commands, add_command, numbers


__all__ = ["add_fly"]


def add_fly(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "fly",
        "fly:run",
        "Fly a planned path in a flight-dynamics model and judge the flight",
        "pathgene fly out/plan/summary.json --wind 8,0 --gusts light",
        usage="[OPTIONS] SUMMARY",
        notes="It needs the extra pathgene[fly]. The exit status is 1 where the flight breaks the "
        "ground, a zone or half the clearance, all as the summary states them; a plan made with "
        "--as-paper is judged without a clearance.",
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
        help="folder of flight.json and flight.png (default: that of SUMMARY)",
    )
