"""``pathgene board``."""

from __future__ import annotations

import argparse
import dataclasses
import socket

from pathgene.host import interrupts
from pathgene.host.cli.arguments import Commands, add_command, add_command_group
from pathgene.host.cli.listening import is_local
from pathgene.host.cli.output import note, print_json, print_pairs
from pathgene.host.errors import InputError, JobError
from pathgene.host.numeric import whole
from pathgene.host.planners import DEFAULT_BOARD


__all__ = ["add", "info", "serve"]

# Period of the checks for a signal, seconds.
_LOOK_S = 1.0


def add(commands: Commands) -> None:
    """Add the command and its commands."""
    actions = add_command_group(
        commands,
        "board",
        "Serve a simulated board, or describe a board",
        "pathgene board info --board sim:",
    )
    serving = add_command(
        actions,
        "serve",
        serve,
        "Serve a simulated board to any serial client",
        "pathgene board serve --board sim: --listen 127.0.0.1:5000",
    )
    serving.add_argument(
        "--board",
        metavar="URL",
        default="sim:",
        help="sim: or model: with its options (default %(default)s)",
    )
    where = serving.add_mutually_exclusive_group()
    where.add_argument(
        "--listen",
        metavar="HOST:PORT",
        default="127.0.0.1:0",
        help="address to listen at; port 0 takes a free port (default %(default)s)",
    )
    where.add_argument("--pty", action="store_true", help="serve a pseudo terminal instead")
    describing = add_command(
        actions,
        "info",
        info,
        "Describe the board at the other end of a link",
        "pathgene board info --board /dev/ttyUSB0 --json",
    )
    describing.add_argument(
        "--board",
        metavar="URL",
        default=DEFAULT_BOARD,
        help="as for pathgene plan (default %(default)s)",
    )


def info(args: argparse.Namespace) -> int:
    """Describe the board of a link."""
    from pathgene.host.device.boards import open_board

    with open_board(args.board) as chip:
        report = {
            "board": args.board,
            "build_id": f"{chip.info['build_id']:08x}",
            "protocol": chip.info["version"],
            "config": dataclasses.asdict(chip.config),
        }
    if args.json:
        print_json(report)
    else:
        print_pairs(
            [
                ("board", args.board),
                ("build id", report["build_id"]),
                ("protocol version", str(report["protocol"])),
                *((name, str(value)) for name, value in report["config"].items()),
            ]
        )
    return 0


def serve(args: argparse.Namespace) -> int:
    """Serve a simulated board until a signal, such as Ctrl-C, or the end of its simulator."""
    from pathgene.host.device.boards import board_scheme

    if not args.pty:
        _check_address(args.listen)
    scheme = board_scheme(args.board)
    with scheme.serve(args.board, listen=args.listen, pty=args.pty) as board:
        if args.json:
            print_json({"board": args.board, "url": board.url, "pid": board.pid})
        else:
            print(board.url, flush=True)
        if not (args.pty or is_local(args.listen.rpartition(":")[0])):
            note(
                f"Anybody who reaches {args.listen} can use this board, which asks for no password."
            )
        try:
            note("Serving until Ctrl-C.")
            # Another thread may take the signal, for example when a stopped process continues; a
            # wait without a limit would never notice it.
            while (status := board.wait(_LOOK_S)) is None:
                pass
        except KeyboardInterrupt:
            return interrupts.status()
        raise JobError(
            f"The simulated board ended by itself with status {status}: "
            f"{board.log().strip() or 'it printed nothing'}."
        )


def _check_address(text: str) -> None:
    """Refuse an address at which nothing can listen, before a simulator is built."""
    host, _, digits = text.rpartition(":")
    try:
        port = whole(digits, 65535)
    except ValueError:
        host = ""
    if not (host and text.isascii()):
        raise InputError(f"The address to listen at must be HOST:PORT, not {text!r}.")
    try:
        with socket.socket() as trial:
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            trial.bind((host, port))
    except OSError as error:
        reason = error.strerror or "unknown reason"
        raise InputError(
            f"Nothing can listen at {text!r} ({reason}); give another --listen."
        ) from None
