"""Arguments of ``pathgene board``."""

from __future__ import annotations

from pathgene.host.cli.arguments.base import Commands, add_command, add_command_group


__all__ = ["add_board"]


def add_board(commands: Commands) -> None:
    """Add the command and its commands."""
    actions = add_command_group(
        commands,
        "board",
        "Serve a simulated board, or describe a board",
        "pathgene board info --board sim:",
    )
    serve = add_command(
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
        help="address to listen at; port 0 takes a free port (default %(default)s)",
    )
    where.add_argument("--pty", action="store_true", help="serve a pseudo terminal instead")
    info = add_command(
        actions,
        "info",
        "board:info",
        "Describe the board at the other end of a link",
        "pathgene board info --board /dev/ttyUSB0 --json",
    )
    info.add_argument(
        "--board",
        metavar="URL",
        default="model:",
        help="as for pathgene plan (default %(default)s)",
    )
