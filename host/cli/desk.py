"""``pathgene desk``."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from host import interrupts
from host.cli.listening import is_local
from host.cli.output import note, print_json
from host.errors import InputError
from host.files.output import prepare_directory


__all__ = ["run"]


def run(args: argparse.Namespace) -> int:
    """Serve the desk until a signal, such as Ctrl-C."""
    try:
        # Loads NiceGUI.
        from host.web.desk.desk import Desk
        from host.web.desk.server import serve
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] == "host":
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
    except (OSError, UnicodeError) as error:  # A name with a part of over 63 letters is the latter.
        reason = getattr(error, "strerror", None) or "unknown reason"
        raise InputError(f"There is no address {host!r} ({reason}); give another --host.") from None
