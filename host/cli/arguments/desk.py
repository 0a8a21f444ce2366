"""Arguments of ``pathgene desk``."""

from __future__ import annotations

from pathgene.host.cli.arguments.base import Commands, add_command


__all__ = ["add_desk"]


def add_desk(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "desk",
        "desk:run",
        "Draw problems, plan them and compare the plans on a local web page",
        "pathgene desk problem.toml --out out/desk",
        notes="Prints the address to open, whose token lets in. Needs the extra pathgene[desk].",
    )
    parser.add_argument(
        "problem",
        metavar="PROBLEM.toml",
        nargs="?",
        help="problem file that the page opens with",
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="address to listen at; 0.0.0.0 lets others in (default %(default)s)",
    )
    parser.add_argument(
        "--port", type=int, metavar="N", default=0, help="port; 0 takes a free one (default 0)"
    )
    parser.add_argument(
        "--open",
        action="store_true",
        help="open the page in your browser, if there is a screen for one",
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        default="out/desk",
        help="directory in which each plan gets its own (default %(default)s)",
    )
    parser.add_argument(
        "--jobs",
        type=int,
        metavar="N",
        default=2,
        help="plans made at a time; others wait (default %(default)s)",
    )
    parser.add_argument(
        "--max-cells",
        type=int,
        metavar="N",
        help="most cells of a terrain that is read (default 25 million)",
    )
