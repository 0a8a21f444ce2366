"""``pathgene desk``."""

from __future__ import annotations

import argparse
import functools
import os
import subprocess
import sys
import threading
from pathlib import Path

from pathgene.host import interrupts
from pathgene.host.cli.arguments import Commands, add_command, add_option
from pathgene.host.cli.listening import is_local
from pathgene.host.cli.output import note, note_start, print_json
from pathgene.host.errors import InputError
from pathgene.host.files.output import prepare_directory
from pathgene.host.options.table import NAMED


__all__ = ["add", "run"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "desk",
        run,
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
    add_option(
        parser,
        NAMED["out"],
        default="out/desk",
        help="directory in which each plan gets its own (default %(default)s)",
    )
    parser.add_argument(
        "--jobs",
        type=int,
        metavar="N",
        default=2,
        help="plans made at a time; more of them wait (default %(default)s)",
    )
    add_option(parser, NAMED["max_cells"])


def run(args: argparse.Namespace) -> int:
    """Serve the desk until a signal, such as Ctrl-C."""
    note_start("Loading the desk.")
    try:
        # Loads NiceGUI.
        from pathgene.host.web.desk.desk import Desk
        from pathgene.host.web.desk.server import serve
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] == "pathgene":
            raise
        raise InputError(
            "The desk needs the extra pathgene[desk]: pip install 'pathgene[desk]'."
        ) from None
    if not 0 <= args.port <= 65535:
        raise InputError(f"The port must be from 0 to 65535, not {args.port}.")
    local = _is_local(args.host)
    directory = Path(args.out)
    prepare_directory(directory)
    problem = None if args.problem is None else Path(args.problem)

    def ready(address: str) -> None:
        if args.json:
            print_json({"url": address, "pid": os.getpid()})
        else:
            print(address, flush=True)
        if not local:
            note(
                f"Anybody who reaches {args.host} and knows this address can plan here and read "
                "the saved plans; nothing is encrypted."
            )
        note("Serving until Ctrl-C.")
        if args.open:
            _open(address)

    desk = Desk(directory, jobs=args.jobs, max_cells=args.max_cells, local=local, problem=problem)
    try:
        serve(desk, args.host, args.port, ready)
    finally:
        if any(job.at_work == "planning" for job in desk.jobs.active):
            note("Saving the best paths of the plans that run ...")
        desk.close()
    return interrupts.status()


def _is_local(host: str) -> bool:
    try:
        return is_local(host)
    except (OSError, UnicodeError) as error:
        reason = "a part of it is empty or over 63 letters long"
        if isinstance(error, OSError):
            reason = error.strerror or "unknown reason"
        raise InputError(f"There is no address {host!r} ({reason}); give another --host.") from None


def _open(address: str) -> None:
    """Open an address in the user's browser, if there is a screen for one.

    A separate process does this and is not waited for: some browsers block their parent until they
    exit, and most print messages. ``TERM`` is unset so that no text browser is chosen.
    """
    screens = ("DISPLAY", "WAYLAND_DISPLAY")
    if sys.platform not in ("darwin", "win32") and not any(map(os.environ.get, screens)):
        return
    opening = functools.partial(
        subprocess.run,
        # Isolated, so that a webbrowser.py in the current folder is not imported.
        [sys.executable, "-I", "-m", "webbrowser", "-t", address],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={key: value for key, value in os.environ.items() if key != "TERM"},
        # Ctrl-C ends the desk but not the browser.
        start_new_session=True,
        check=False,
    )
    threading.Thread(target=opening, daemon=True).start()
