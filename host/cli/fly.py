"""``pathgene fly``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from host.cli.output import note, print_json, print_pairs
from host.files.output import prepare_directory, writing_into
from host.flight.fly import fly, save
from host.flight.models import model_named
from host.report.read import read_run


__all__ = ["run"]


def run(args: argparse.Namespace) -> int:
    """Fly the path of a summary; a flight that breaks something is a failure."""
    file = Path(args.summary)
    if args.aircraft is not None:
        model_named(args.aircraft)  # Refused before anything is read.
    run = read_run(file)
    directory = Path(args.out) if args.out else file.parent
    prepare_directory(directory)
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
