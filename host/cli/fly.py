"""``pathgene fly``."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import Any

from host.cli.output import note, print_json, print_pairs
from host.errors import InputError
from host.files.output import prepare_directory, writing_into
from host.flight.fly import fly, save
from host.flight.models import model_named
from host.planners.default import named_or_default
from host.replanning.fly import fly_scenario
from host.replanning.fly import save as save_replanned
from host.replanning.scenario import Scenario, parse_popup, read_scenario
from host.report.read import Run, read_run
from host.terrain import Terrain


__all__ = ["run"]


def run(args: argparse.Namespace) -> int:
    """Fly the path of a summary; a flight that breaks something is a failure."""
    file = Path(args.summary)
    if args.aircraft is not None:
        model_named(args.aircraft)  # Refused before anything is read.
    run = read_run(file)
    scenario = _scenario(args, run.problem.terrain)
    directory = Path(args.out) if args.out else file.parent
    prepare_directory(directory)
    if scenario.events:
        return _replan(args, run, scenario, directory)
    report = fly(
        run.problem, run.path, args.aircraft, wind=args.wind, gusts=args.gusts, seed=args.seed
    )
    with writing_into(directory):
        written = save(report, directory)
    table = {key: value for key, value in report.to_dict().items() if key != "track"}
    if args.json:
        print_json(table | {"files": list(map(str, written))})
    else:
        print_pairs([*_pairs(table), ("files", ", ".join(map(str, written)))])
    for sentence in report.verdict.breaks:
        note(sentence)
    return 0 if report.verdict.kept else 1


def _scenario(args: argparse.Namespace, terrain: Terrain) -> Scenario:
    """Return what happens in the flight."""
    scenario = Scenario(tuple(parse_popup(text, terrain) for text in args.popup))
    if args.scenario is not None:
        scenario = read_scenario(args.scenario) + scenario
    if scenario.events and args.aircraft is not None:
        raise InputError("The aircraft that replans is the one planned for; leave --aircraft out.")
    if scenario.events and args.wind is not None:
        raise InputError(
            "The wind of a flight that replans is the one planned for; give another in a scenario."
        )
    if args.planner_seconds is not None and not 0 <= args.planner_seconds < math.inf:
        raise InputError(f"--planner-seconds must be 0 or more, not {args.planner_seconds:g}.")
    return scenario


def _replan(args: argparse.Namespace, run: Run, scenario: Scenario, directory: Path) -> int:
    """Fly the path while the scenario happens."""
    planner = named_or_default(args.planner, {"board": args.board})
    report = fly_scenario(
        run.problem,
        run.path,
        scenario,
        planner=planner,
        board=args.board,
        seconds=args.planner_seconds,
        gusts=args.gusts,
        seed=args.seed,
        say=note,
    )
    with writing_into(directory):
        written = save_replanned(report, directory)
    table = {key: value for key, value in report.to_dict().items() if key != "track"}
    if args.json:
        print_json(table | {"files": list(map(str, written))})
    else:
        print_pairs([*_replan_pairs(table), ("files", ", ".join(map(str, written)))])
    for sentence in report.outcome.breaks:
        note(sentence)
    return 0 if report.outcome.kept else 1


def _replan_pairs(table: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the terms of a flight with replans as names and texts with units."""
    board = f", board {table['board']}" if table["board"] else ""
    distance = table["zone_distance_m"]
    rows = [
        ("kept", "yes" if table["kept"] else "no"),
        ("ended", table["ended"]),
        ("aircraft", table["aircraft"]),
        ("planner", f"{table['planner']}{board}, {table['processor_ms']:.0f} ms of the processor"),
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
    worst = table["limits"][0]
    return [
        ("kept", "yes" if table["kept"] else "no"),
        ("aircraft", table["aircraft"]),
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
