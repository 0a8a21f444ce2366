"""``pathgene auv``."""

from __future__ import annotations

import argparse
import contextlib
import itertools
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pathgene.host import interrupts
from pathgene.host.auv import PLANNERS
from pathgene.host.cli.arguments import Commands, add_command, add_options
from pathgene.host.cli.drawing import import_quickly
from pathgene.host.cli.ending import ending
from pathgene.host.cli.output import (
    note,
    note_compiling_routes,
    note_start,
    print_json,
    print_pairs,
)
from pathgene.host.errors import InputError
from pathgene.host.files.output import json_bytes, prepare_directory, writing_into
from pathgene.host.files.replacement import replace_files
from pathgene.host.options.table import NAMED, OWN
from pathgene.host.progress import Bar


if TYPE_CHECKING:
    from pathgene.host.auv.field import AuvField
    from pathgene.host.planners.routes.field import Route


__all__ = ["add", "run"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "auv",
        run,
        "Plan the path of an underwater vehicle, the problem of ga-dp",
        "pathgene auv --landscape 1 --planner ga-dp --seed 1 --out auv",
    )
    parser.add_argument(
        "--landscape", type=int, metavar="N", default=1, help="1 or 2 (default %(default)s)"
    )
    parser.add_argument(
        "--planner",
        choices=PLANNERS,
        default=PLANNERS[0],
        help="the planner of the paper, or the conventional GA that it is compared with "
        "(default %(default)s)",
    )
    add_options(parser, [OWN[name] for name in ("reading", "draws", "added_points")])
    parser.add_argument(
        "--as-paper",
        action="store_true",
        help="read the seabed as in the paper, at 21 samples per segment, even in the spline's "
        "parameter, which step over hills; without it the samples are even in arc length, and as "
        "many as it takes",
    )
    parser.add_argument(
        "--samples",
        type=int,
        metavar="N",
        help="read the seabed in the paper's way at N samples per segment (--as-paper: 21)",
    )
    parser.add_argument(
        "--length",
        choices=("2d", "3d"),
        default="2d",
        help="horizontal length, or length along the seabed (default %(default)s)",
    )
    parser.add_argument(
        "--generations", type=int, metavar="N", help="number of generations (default 100)"
    )
    add_options(parser, [NAMED["seed"], NAMED["out"]])


def run(args: argparse.Namespace) -> int:
    """Plan, write the files and print the summary."""
    note_start("Loading the planner.")
    from pathgene.host.auv.field import PAPER_SAMPLES, AuvField
    from pathgene.host.auv.plan import GENERATIONS, describe, evolve, terms
    from pathgene.host.planners.base import Stop
    from pathgene.host.planners.routes.field import READINGS
    from pathgene.host.planners.routes.point_sampler import KINDS
    from pathgene.host.planners.routes.search import ADDED_POINTS
    from pathgene.host.report.summary import version

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


def _write(directory: Path, field: AuvField, route: Route, summary: dict[str, Any]) -> list[Path]:
    import_quickly()
    from pathgene.host.auv.picture import write

    written = [directory / "auv.json", directory / "auv.png"]
    with writing_into(directory):
        # A picture left from an earlier run would be misleading.
        replace_files(directory, {written[0].name: json_bytes(summary)}, gone=[written[1].name])
        write(field, route, summary, written[1])
    return written


def _print(summary: dict[str, Any], written: list[Path]) -> None:
    from pathgene.host.auv.plan import REPORT_SAMPLES

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
