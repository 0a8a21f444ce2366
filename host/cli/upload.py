"""``pathgene upload``."""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path
from typing import TYPE_CHECKING

from pathgene.host.cli.arguments import Commands, add_command, add_option
from pathgene.host.cli.last_door import check_path
from pathgene.host.cli.output import note, note_reading, print_json, print_pairs
from pathgene.host.errors import InputError, JobError
from pathgene.host.options.table import NAMED


if TYPE_CHECKING:
    from pathgene.host.formats.flight_plan import FlightPlan


__all__ = ["add", "run"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "upload",
        run,
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
        help="kind of the autopilot (default: as its heartbeat says); ArduPilot takes item 0 "
        "as home",
    )
    parser.add_argument(
        "--timeout",
        type=float,
        metavar="S",
        default=10.0,
        help="maximum wait for the autopilot's heartbeat, seconds (default %(default)g)",
    )
    add_option(parser, NAMED["origin"])
    parser.add_argument(
        "--infeasible", action="store_true", help="upload a path that is not feasible, too"
    )


def run(args: argparse.Namespace) -> int:
    """Upload, and print the numbers of items that the autopilot has confirmed."""
    from pathgene.host.formats.flight_plan import FenceCircle
    from pathgene.host.mission.autopilot.mavlink_link import NoReplyError, open_link
    from pathgene.host.mission.autopilot.upload import AUTOPILOTS, upload

    if not (math.isfinite(args.timeout) and args.timeout > 0):
        raise InputError(f"--timeout must be a positive number of seconds, not {args.timeout:g}.")
    plan = _plan(args)
    if plan.feasible is False and not args.infeasible:
        raise JobError(
            f"{args.file}: the path is not feasible, so nothing is uploaded; plan again, or give "
            "--infeasible."
        )
    for sentence in plan.notes:
        note(sentence)
    started_s = time.monotonic()
    link = open_link(args.to, baud=args.baud)
    try:
        link.find(args.timeout)
        done = upload(plan, link, autopilot=AUTOPILOTS.get(args.autopilot))
    except NoReplyError:
        raise JobError(
            f"No autopilot answers at {args.to} within {args.timeout:g} s; check the address, "
            "the link and the autopilot (--timeout)."
        ) from None
    except OSError as error:
        raise JobError(
            f"The connection to {args.to} broke ({error.strerror or error}); upload again."
        ) from None
    finally:
        link.close()
    report = {
        "to": args.to,
        "system": done.system,
        "autopilot": done.autopilot_name,
        "mission_items": done.mission_items,
        "fence_items": done.fence_items,
        "fences": len(plan.fence),
        "equal": True,
        "notes": list(plan.notes),
        "seconds": round(time.monotonic() - started_s, 3),
    }
    if args.json:
        print_json(report)
    else:
        circles = sum(isinstance(fence, FenceCircle) for fence in plan.fence)
        print_pairs(
            [
                ("autopilot", f"{done.autopilot_name}, system {done.system}"),
                ("mission", f"{done.mission_items} items, read back equal"),
                (
                    "fence",
                    f"{circles} circles and {len(plan.fence) - circles} polygons, read back equal",
                ),
                ("time", f"{report['seconds']:.1f} s"),
            ]
        )
    return 0


def _plan(args: argparse.Namespace) -> FlightPlan:
    """Return the flight plan in the file."""
    from pathgene.host.evaluation import Evaluator
    from pathgene.host.formats.plan import read_plan
    from pathgene.host.mission.autopilot.flight_plan import flight_plan
    from pathgene.host.report.read import read_run

    file = Path(args.file)
    if file.suffix.lower() == ".plan":
        if args.origin is not None:
            raise InputError("A .plan file has its place on Earth; leave --origin out.")
        return read_plan(file)
    planned = read_run(file, origin=args.origin)
    note_reading(planned.summary.get("read"))
    if not args.infeasible:
        check_path(planned, "nothing is uploaded", "plan again, or give --infeasible")
    track = Evaluator(planned.problem).track(planned.path)
    return flight_plan(planned.problem, track, feasible=planned.feasible)
