"""``pathgene plan``."""

from __future__ import annotations

import argparse
import contextlib
import sys
from pathlib import Path
from typing import Any

from host import interrupts
from host.cli.ending import ending
from host.cli.options import own_options
from host.cli.output import note, print_json, print_pairs, term_pairs
from host.cli.problem import make_problem, source_of
from host.errors import JobError
from host.evaluation import Evaluator
from host.planners import PLANNERS, make
from host.planners.base import Options, Result, Stop
from host.progress import Progress
from host.report.files import prepare_directory
from host.report.summary import summarise
from host.report.write import write_report


__all__ = ["run"]

_BOARD = "model:"


def run(args: argparse.Namespace) -> int:
    """Plan, write the files and print the summary."""
    planner = make(args.planner, **own_options(args, args.planner))
    generations = args.generations
    if generations is None:
        generations = PLANNERS[args.planner].generations
    options = Options(
        generations=generations,
        time_limit_s=args.time_limit,
        target_fitness=args.target_fitness,
        population=args.population,
        seed=args.seed,
    )
    evaluator = Evaluator(make_problem(args))
    directory = Path(args.out)
    prepare_directory(directory)

    stop = Stop()
    progress = Progress(sys.stderr, options.generations)
    board = (args.board or _BOARD) if "board" in PLANNERS[args.planner].options else None
    with ending(stop):
        with contextlib.closing(progress):
            result = planner.plan(evaluator, options, progress, stop)
        stop.heeded = True
        summary = summarise(
            evaluator,
            result,
            planner=args.planner,
            board=board,
            seed=args.seed,
            source=source_of(args),
        )
        written = write_report(directory, evaluator, result, summary, warn=note)
    if args.json:
        print_json(summary)
    else:
        _print(summary, written)
    return _status(result)


def _status(result: Result) -> int:
    """Exit status; raises the sentence of a job that failed, now that its files are written."""
    if result.interrupted:
        note("Interrupted; what was best so far is written.")
        return interrupts.status()
    if result.failure is not None:
        raise JobError(f"{result.failure.rstrip('.')}; what was best until then is written.")
    if not result.evaluation.feasible:
        raise JobError(
            "No feasible path was found, the best one is written; try more "
            "--generations, another --seed, or move start and goal."
        )
    return 0


def _print(summary: dict[str, Any], written: list[Path]) -> None:
    print_pairs(
        [
            ("planner", summary["planner"]),
            ("board", summary["board"] or "none"),
            *term_pairs(summary),
            ("generations", f"{summary['generations']}"),
            ("evaluations", f"{summary['evaluations']}"),
            *_counted(summary["hardware"] or {}),
            ("time", f"{summary['seconds']['total']:.2f} s"),
            *(("written", str(path)) for path in written),
        ]
    )


def _counted(hardware: dict[str, Any]) -> list[tuple[str, str]]:
    """What the board's collision checker did and saved, if it was asked to."""
    if (counted := hardware.get("feasibility")) is None:
        return []
    refuted = sum(counted["refuted_by"].values())
    return [
        ("counted on board", f"{counted['counted_on_board']} paths"),
        (
            "  evaluated in full",
            f"{counted['evaluated_in_full']}, of which {refuted} were counted feasible and are not",
        ),
        ("  samples saved", f"{counted['host_samples_saved']}"),
    ]
