"""``pathgene auv``."""

from __future__ import annotations

import argparse
import contextlib
import itertools
import sys
import time
from pathlib import Path
from typing import Any

from pathgene.host import interrupts
from pathgene.host.auv.field import PAPER_SAMPLES, AuvField
from pathgene.host.auv.plan import GENERATIONS, REPORT_SAMPLES, describe, evolve, terms
from pathgene.host.cli.compiling import note_compiling_routes
from pathgene.host.cli.ending import ending
from pathgene.host.cli.output import note, print_json, print_pairs
from pathgene.host.errors import InputError
from pathgene.host.files.output import json_bytes, prepare_directory, writing_into
from pathgene.host.files.replacement import replace_files
from pathgene.host.planners.base import Stop
from pathgene.host.planners.routes.field import READINGS, Route
from pathgene.host.planners.routes.point_sampler import KINDS
from pathgene.host.planners.routes.search import ADDED_POINTS
from pathgene.host.progress import Bar
from pathgene.host.report.summary import version


__all__ = ["run"]


def run(args: argparse.Namespace) -> int:
    """Plan, write the files and print the summary."""
    generations = GENERATIONS if args.generations is None else args.generations
    if generations < 1:
        raise InputError(f"The number of generations must be 1 or more, not {generations}.")
    field = AuvField(
        args.landscape,
        reading=args.reading or READINGS[0],
        samples=PAPER_SAMPLES if args.as_paper and args.samples is None else args.samples,
        in_space=args.length == "3d",
    )
    draws = args.draws or KINDS[0]
    added = ADDED_POINTS if args.added_points is None else args.added_points
    search = evolve(field, args.planner, draws=draws, added=added, seed=args.seed)
    directory = Path(args.out)
    prepare_directory(directory)
    note_compiling_routes()

    started = time.perf_counter()
    routes: list[Route] = []
    stop = Stop()
    with ending(stop):
        with contextlib.closing(Bar(sys.stderr, generations)) as progress:
            try:
                for generation in itertools.islice(search, generations):
                    routes.append(generation.best)
                    delta = terms(field, generation.best)["delta"]
                    progress.show(
                        len(routes), f"generation {len(routes)}/{generations}  delta {delta:.4f}"
                    )
                    if stop.requested:
                        break
            except KeyboardInterrupt:
                if not routes:
                    raise
            finally:
                stop.heeded = True
        interrupted = stop.requested
        summary = {
            "pathgene": version(),
            "planner": args.planner,
            "draws": draws,
            "added_points": added,
            "seed": args.seed,
            "generations": len(routes),
            "interrupted": interrupted,
            "seconds": time.perf_counter() - started,
            **describe(field, routes),
        }
        written = _write(directory, field, routes[-1], summary)
    if args.json:
        print_json(summary)
    else:
        _print(summary, written)
    if interrupted:
        note("Interrupted; the best path so far is written.")
        return interrupts.status()
    return 0


def _write(
    directory: Path,
    field: AuvField,
    route: Route,
    summary: dict[str, Any],
) -> list[Path]:
    from pathgene.host.auv.picture import write

    written = [directory / "auv.json", directory / "auv.png"]
    with writing_into(directory):
        # A picture of an earlier run would mislead.
        replace_files(directory, {written[0].name: json_bytes(summary)}, gone=[written[1].name])
        write(field, route, summary, written[1])
    return written


def _print(summary: dict[str, Any], written: list[Path]) -> None:
    fine = summary[f"at_{REPORT_SAMPLES}_samples"]
    names = {
        "delta": "delta",
        "path_length": "path length",
        "elevation_rate": "elevation rate",
        "minimum_turn_deg": "minimum turn, degrees",
    }
    print_pairs(
        [
            (
                "planner",
                f"{summary['planner']}, reading {summary['reading']}, draws {summary['draws']}",
            ),
            ("samples of a segment", f"{_samples(summary)}, and {REPORT_SAMPLES}"),
            *((text, f"{summary[name]:.4f}, and {fine[name]:.4f}") for name, text in names.items()),
            ("  crossover points too", f"{summary['minimum_turn_at_crossover_deg']:.4f}"),
            ("crossover points", f"{len(summary['crossover_points'])}, start and goal included"),
            ("generations", f"{summary['generations']}"),
            ("time", f"{summary['seconds']:.2f} s"),
            *(("written", str(path)) for path in written),
        ]
    )


def _samples(summary: dict[str, Any]) -> str:
    least, most = min(summary["segment_samples"]), max(summary["segment_samples"])
    return f"{least}" if least == most else f"{least} to {most}"
