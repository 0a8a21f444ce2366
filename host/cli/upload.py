"""``pathgene upload``."""

from __future__ import annotations

import argparse
import math
import time
from pathlib import Path

from pathgene.host.cli.last_door import check_path
from pathgene.host.cli.output import note, print_json, print_pairs
from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.formats.flight_plan import FenceCircle, FlightPlan
from pathgene.host.formats.plan import read_plan
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.mission.autopilot.mavlink_link import NoReplyError, open_link
from pathgene.host.mission.autopilot.upload import AUTOPILOTS, upload
from pathgene.host.report.read import read_run


__all__ = ["run"]


def run(args: argparse.Namespace) -> int:
    """Upload, and print the numbers of items that the autopilot has confirmed."""
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
    file = Path(args.file)
    if file.suffix.lower() == ".plan":
        if args.origin is not None:
            raise InputError("A .plan file has its place on Earth; leave --origin out.")
        return read_plan(file)
    planned = read_run(file, origin=args.origin)
    if not args.infeasible:
        check_path(planned, "nothing is uploaded", "plan again, or give --infeasible")
    track = Evaluator(planned.problem).track(planned.path)
    return flight_plan(planned.problem, track, feasible=planned.feasible)
