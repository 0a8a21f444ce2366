"""``pathgene fly``."""

from __future__ import annotations

import argparse
import contextlib
import functools
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from pathgene.host import interrupts
from pathgene.host.cli.arguments import Commands, add_command, add_options
from pathgene.host.cli.drawing import import_quickly
from pathgene.host.cli.ending import ending
from pathgene.host.cli.output import note, note_reading, note_start, print_json, print_pairs
from pathgene.host.errors import InputError, JobError
from pathgene.host.files.output import prepare_directory, writing_into
from pathgene.host.options.kinds import PATH
from pathgene.host.options.table import NAMED, ZONE_READING
from pathgene.host.planners import DEFAULT_BOARD
from pathgene.host.progress import Bar
from pathgene.host.stages import watched_by


if TYPE_CHECKING:
    from pathgene.host.flight.report import FlightReport
    from pathgene.host.replanning.outcome import Replanned
    from pathgene.host.replanning.scenario import Scenario
    from pathgene.host.report.read import Run


__all__ = ["add", "run"]

# Quoted: the classes are imported only for type checking.
_Report = TypeVar("_Report", "FlightReport", "Replanned")


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "fly",
        run,
        "Fly a planned path in a flight-dynamics model and judge the flight",
        "pathgene fly out/plan/summary.json --gusts light --popup ahead:1500,300@40",
        usage="[OPTIONS] SUMMARY",
        notes="It needs the extra pathgene[fly]. The exit status is 1 where the flight breaks the "
        "ground, a zone or half the clearance, all as the summary states them; a plan made with "
        "--as-paper is judged without a clearance. With --popup or --scenario the planner plans "
        "again in flight, in simulated time: chip cycles, bits on the line, and the processor's "
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
        type=NAMED["wind"].kind.parse,
        help="wind in m/s towards true east and true north (default: the one planned for)",
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
        "--guidance",
        metavar="NAME",
        default="ideal",
        help="ideal follows the planned path itself; ardupilot or px4 flies the exported mission, "
        "item by item and with its end, by the laws of that autopilot; needs the extra "
        "pathgene[mavlink] (default %(default)s)",
    )
    parser.add_argument(
        "--out",
        type=PATH.parse,
        metavar="DIR",
        help="folder of flight.json, flight.png and flight.gif (default: the folder of SUMMARY)",
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
    add_options(group, ZONE_READING)
    group.add_argument("--scenario", metavar="FILE.toml", help="events during the flight; see docs")
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
        help="time of a plan on the processor, with a chip the host's share of it "
        "(default: measured before the flight; processor_ms in flight.json)",
    )


def run(args: argparse.Namespace) -> int:
    """Fly the path of a summary; a flight that breaks a limit is a failure."""
    note_start("Reading the plan.")
    from pathgene.host.flight import fly as flight
    from pathgene.host.flight.models import model_named
    from pathgene.host.mission.autopilot.hand_over import HandOver
    from pathgene.host.mission.ending import summary_ending
    from pathgene.host.planners import named_or_default
    from pathgene.host.replanning import fly as replanning
    from pathgene.host.report.read import read_run

    file = Path(args.summary)
    if args.aircraft is not None:
        model_named(args.aircraft)  # Refuse it before reading anything.
    run = read_run(file)
    note_reading(run.summary.get("read"))
    scenario = _scenario(args, run)
    for read in scenario.readings:
        note_reading({"terrain": {}, "zones": read.to_dict()})
    directory = Path(args.out) if args.out else file.parent
    prepare_directory(directory)
    weather = {"gusts": args.gusts, "seed": args.seed}
    if not scenario.events:
        begin = functools.partial(
            flight.fly,
            run.problem,
            run.path,
            args.aircraft,
            wind=args.wind,
            guidance=args.guidance,
            wanted=HandOver(ending=summary_ending(file, run.summary)),
            **weather,
        )
        return _flown(args, directory, begin, flight.write, flight.draw, _pairs)
    replan = functools.partial(
        replanning.fly_scenario,
        run.problem,
        run.path,
        scenario,
        planner=named_or_default(args.planner, {"board": args.board}),
        board=args.board,
        seconds=args.planner_seconds,
        say=note,
        **weather,
    )
    return _flown(args, directory, replan, replanning.write, replanning.draw, _replan_pairs)


def _scenario(args: argparse.Namespace, run: Run) -> Scenario:
    """Return the events of the flight; files of zones are read like the plan's files."""
    from pathgene.host.flight.autopilots import IDEAL
    from pathgene.host.mission.build import (
        options_for_flight,
        zone_choices_of,
        zone_options_of,
    )
    from pathgene.host.replanning.scenario import Scenario, parse_popup, read_scenario

    problem = run.problem
    given = {option.name: getattr(args, option.name) for option in ZONE_READING}
    values = {
        **zone_choices_of(problem.zones_reading),
        **{name: value for name, value in given.items() if value},
    }
    options = options_for_flight(
        zone_options_of(values),
        problem.terrain,
        problem.aircraft,
        problem.limits.ceiling_m,
        problem.wind,
        len(problem.way),
    )
    scenario = Scenario(tuple(parse_popup(text, problem.terrain, options) for text in args.popup))
    if args.scenario is not None:
        scenario = read_scenario(args.scenario) + scenario
    if scenario.events and args.aircraft is not None:
        raise InputError("The aircraft that replans is the one planned for; leave --aircraft out.")
    if scenario.events and args.guidance != IDEAL:
        raise InputError(
            f"--guidance {args.guidance} flies an exported mission, which does not change in "
            "flight; leave --popup and --scenario out, or --guidance."
        )
    if scenario.events and args.wind is not None:
        raise InputError(
            "The wind of a flight that replans is the one planned for; give another in a scenario."
        )
    if args.planner_seconds is not None and not 0 <= args.planner_seconds < math.inf:
        raise InputError(f"--planner-seconds must be 0 or more, not {args.planner_seconds:g}.")
    return scenario


def _flown(
    args: argparse.Namespace,
    directory: Path,
    begin: Callable[..., _Report],
    write: Callable[[_Report, Path], Path],
    draw: Callable[[_Report, Path], list[Path]],
    pairs: Callable[[dict[str, Any]], list[tuple[str, str]]],
) -> int:
    """Fly, write the files and print the verdict; return the exit status.

    A signal ends the flight; the part already flown is written without pictures.
    """
    from pathgene.host.planners.base import Stop
    from pathgene.host.report.run_files import FLIGHT

    stop = Stop()
    with ending(stop):
        try:
            with contextlib.closing(Bar(sys.stderr, 1)) as bar, watched_by(bar.stage):
                report = begin(stop=stop)
        except (KeyboardInterrupt, JobError) as error:
            # A signal to the process group also ends child processes, such as a compiler.
            if isinstance(error, JobError) and not stop.requested:
                raise
            note(f"Interrupted before the flight began; nothing is written to {directory}.")
            return interrupts.status()
        with writing_into(directory):
            written = [write(report, directory)]
    table: dict[str, Any] = report.to_dict()
    whole = "Interrupted; the flight is written, but not all of its pictures."
    ended = ""
    if stop.requested:
        # A signal may arrive just after the flight has ended by itself.
        ended = "Interrupted; the flight until then is written." if table["interrupted"] else whole
    else:
        try:
            with writing_into(directory):
                import_quickly()
                written += draw(report, directory)
        except KeyboardInterrupt:
            ended = whole
            # Files of an earlier flight are already removed.
            written = [file for name in FLIGHT if (file := directory / name).exists()]
    del table["track"]
    if args.json:
        print_json(table | {"files": list(map(str, written))})
    else:
        print_pairs([*pairs(table), ("files", ", ".join(map(str, written)))])
    for sentence in (*table.get("notes", ()), *table["breaks"]):
        note(sentence)
    if ended:
        note(ended)
        return interrupts.status()
    return 0 if table["kept"] else 1


def _replan_pairs(table: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the terms of a flight with replans as names and texts with units."""
    board = f", board {table['board']}" if table["board"] else ""
    distance = table["zone_distance_m"]
    rows = [
        ("kept", "yes" if table["kept"] else "no"),
        ("ended", table["ended"]),
        ("aircraft", table["aircraft"]),
        ("planner", f"{table['planner']}{board}, {table['processor_ms']:.4g} ms of the processor"),
        ("flight time", f"{table['flight_time_s']:.0f} s"),
    ]
    for change in table["changes"]:
        if change["active_ms"] is not None:
            became = (
                f"new path after {change['active_ms']:.1f} ms, {change['flown_m']:.2f} m flown, "
                f"F {change['fitness']:.4f}"
            )
        else:
            became = "no new path" if change["needed"] else "flown on"
        rows.append((f"at {change['at_s']:.0f} s", f"{change['what']}: {became}"))
    return [
        *rows,
        ("clearance", f"{table['clearance_flown_m']:.1f} m flown"),
        ("zones", "none" if distance is None else f"{distance:.0f} m away at least"),
    ]


def _pairs(table: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the terms of a flight as names and texts with units."""
    clearance = table["clearance_flown_m"]
    guidance = table["guidance"]
    if table["items"]:
        guidance += f", {table['items']} items and the end of the mission, in JSBSim"
    worst = table["limits"][0]
    return [
        ("kept", "yes" if table["kept"] else "no"),
        ("aircraft", table["aircraft"]),
        ("guidance", guidance),
        ("flight time", f"{table['flight_time_s']:.0f} s"),
        ("cross-track", f"{table['cross_track_rms_m']:.1f} m rms, "
         f"{table['cross_track_max_m']:.1f} m at most"),
        ("height error", f"{table['height_error_rms_m']:.1f} m rms, "
         f"{table['height_error_max_m']:.1f} m at most"),
        ("clearance", f"{'unknown' if clearance is None else f'{clearance:.1f} m'} flown, "
         f"{table['clearance_planned_m']:.1f} m planned, {table['clearance_asked_m']:.1f} m asked"),
        ("zones entered", ", ".join(table["zones_entered"]) or "none"),
        ("airspeed", "{:.1f} to {:.1f} m/s".format(*table["airspeed_m_s"])),
        (
            "worst limit" if worst["excess"] > 0 else "nearest limit",
            f"{worst['limit']}, {100 * (1 + worst['excess']):.0f} % of it",
        ),
    ]  # fmt: skip
