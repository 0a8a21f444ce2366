"""``pathgene upload``."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pathgene.host.cli.arguments import Commands, add_command, add_end, add_option
from pathgene.host.cli.last_door import check_path, ending_for
from pathgene.host.cli.output import note, note_reading, note_start, print_json, print_pairs
from pathgene.host.errors import InputError, JobError
from pathgene.host.options.table import NAMED, options_of


if TYPE_CHECKING:
    from pathgene.host.formats.flight_plan import FlightPlan
    from pathgene.host.problem.problem import Problem


__all__ = ["add", "run"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "upload",
        run,
        "Upload a planned path, its fences and rally points to an autopilot",
        "pathgene upload out/summary.json --to udpout:127.0.0.1:14550",
        notes="Mission, fence and rally points are read back and compared. If anything differs, "
        "the autopilot gets its earlier lists back, and the exit status is 1. It is also 1 if the "
        "autopilot will not start the mission. Needs the extra pathgene[mavlink].",
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
        "--system",
        type=int,
        metavar="ID",
        help="system of the autopilot, 1 to 255 (default: the only one that answers)",
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
    add_option(parser, NAMED["fence_corners"])
    add_option(parser, NAMED["simplify"])
    add_end(parser)
    parser.add_argument(
        "--set-parameters",
        action="store_true",
        help="set parameters of the autopilot that do not suit the mission: its return height, "
        "those that enable fences, and with PX4 the tolerance of heights",
    )
    parser.add_argument(
        "--infeasible",
        action="store_true",
        help="upload a path that is not feasible, or that an autopilot climbs too late for, too",
    )


def run(args: argparse.Namespace) -> int:
    """Upload, and print the numbers of items that the autopilot has confirmed."""
    note_start("Reading the mission.")
    from pathgene.host.formats.flight_plan import FenceCircle
    from pathgene.host.mission.autopilot.advice import WANTED, advise
    from pathgene.host.mission.autopilot.flight_state import start_refusal
    from pathgene.host.mission.autopilot.mavlink_link import NoReplyError, open_link
    from pathgene.host.mission.autopilot.parameters import read_parameters, set_parameters
    from pathgene.host.mission.autopilot.upload import AUTOPILOTS, upload

    if not (math.isfinite(args.timeout) and args.timeout > 0):
        raise InputError(f"--timeout must be a positive number of seconds, not {args.timeout:g}.")
    if args.system is not None and not 1 <= args.system <= 255:
        raise InputError(f"--system must be from 1 to 255, not {args.system}.")
    make, problem = _maker(args)
    started_s = time.monotonic()
    link = open_link(args.to, baud=args.baud)
    try:
        link.find(args.timeout, args.system)
        kind = AUTOPILOTS.get(args.autopilot, link.autopilot)
        plan = make(kind)
        for sentence in plan.notes:
            note(sentence)
        done = upload(plan, link, autopilot=kind, fence_corners=args.fence_corners)
        found = read_parameters(link, kind, WANTED.get(kind, ()))
        advice = advise(plan, found, kind, problem)
        unset = set_parameters(link, kind, advice.values) if args.set_parameters else []
    except NoReplyError as error:
        raise JobError(_silence(args, error.systems)) from None
    except OSError as error:
        raise JobError(
            f"The connection to {args.to} broke ({error.strerror or error}); upload again."
        ) from None
    finally:
        link.close()
        for text in link.texts.all:
            note(f'The autopilot says "{text}".')
    values = dict(advice.values)
    for sentence in (*advice.sentences, *_changes(values, unset, is_asked=args.set_parameters)):
        note(sentence)
    refusal = start_refusal(done.mission, link.texts.all)
    report = {
        "to": args.to,
        "system": done.system,
        "autopilot": done.autopilot_name,
        "mission_items": done.mission_items,
        "fence_items": done.fence_items,
        "fences": len(plan.fence),
        "rally_points": done.rally_points,
        "equal": True,
        "will_start": done.mission.will_start,
        "begins_with_item": done.mission.item,
        "texts": link.texts.all,
        "parameters": {
            "read": found,
            "advised": values,
            "set": args.set_parameters and not unset,
            "notes": list(advice.sentences),
        },
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
                (
                    "rally points",
                    "the autopilot has no such list"
                    if done.rally_points is None
                    else f"{done.rally_points}, read back equal",
                ),
                ("time", f"{report['seconds']:.1f} s"),
            ]
        )
    if refusal is not None:
        raise JobError(refusal)
    return 0


def _changes(values: dict[str, float], unset: list[str], *, is_asked: bool) -> Iterator[str]:
    """Yield a sentence about parameters that are set, or that could be."""
    shown = " and ".join(f"{name} {value:g}" for name, value in values.items())
    if unset:
        yield (
            f"The autopilot does not take {unset[0]}, so its parameters stay as they were; set "
            f"{shown} in a ground station."
        )
    elif values and is_asked:
        yield f"The autopilot now has {shown}, read back equal."
    elif values:
        yield f"Set {shown} in a ground station, or upload again with --set-parameters."


def _silence(args: argparse.Namespace, others: tuple[int, ...]) -> str:
    """Return the sentence about an autopilot that does not answer."""
    if others:
        return (
            f"System {args.system} does not answer at {args.to} within {args.timeout:g} s, but "
            f"{', '.join(map(str, others))} does; choose another one with --system, or check the "
            "link."
        )
    return (
        f"No autopilot answers at {args.to} within {args.timeout:g} s; check the address, the link "
        "and the autopilot (--timeout)."
    )


def _maker(args: argparse.Namespace) -> tuple[Callable[[int], FlightPlan], Problem | None]:
    """Check the file; return a function that makes its flight plan for a kind of autopilot.

    A file with terrain has a problem, too.
    """
    from pathgene.host.evaluation import Evaluator
    from pathgene.host.formats.plan import read_plan
    from pathgene.host.mission.autopilot.flight_plan import flight_plan
    from pathgene.host.mission.autopilot.hand_over import hand_over_of
    from pathgene.host.report.read import read_run

    hand_over_of(vars(args))
    file = Path(args.file)
    if file.suffix.lower() == ".plan":
        if args.origin is not None:
            raise InputError("A .plan file has its place on Earth; leave --origin out.")
        if any(getattr(args, option.name) is not None for option in options_of("end")):
            raise InputError("A .plan file has its own end; leave --end and --land out.")
        if args.simplify is not None:
            raise InputError("A .plan file has its own waypoints; leave --simplify out.")
        plan = read_plan(file)
        _require(plan.feasible, args)
        return lambda kind: plan, None
    planned = read_run(file, origin=args.origin)
    note_reading(planned.summary.get("read"))
    if not args.infeasible:
        check_path(planned, "nothing is uploaded", "plan again, or give --infeasible")
    _require(planned.feasible, args)
    track = Evaluator(planned.problem).track(planned.path)
    ending = ending_for(args, planned)

    def make(kind: int | None) -> FlightPlan:
        wanted = replace(hand_over_of(vars(args), kind), ending=ending)
        feasible = False if args.infeasible else planned.feasible
        return flight_plan(planned.problem, track, feasible=feasible, wanted=wanted)

    make(None)  # An end without room is refused before the autopilot is called.
    return make, planned.problem


def _require(feasible: bool | None, args: argparse.Namespace) -> None:
    """Refuse a path that is not feasible, unless the user wants it."""
    if feasible is False and not args.infeasible:
        raise JobError(
            f"{args.file}: the path is not feasible, so nothing is uploaded; plan again, or give "
            "--infeasible."
        )
