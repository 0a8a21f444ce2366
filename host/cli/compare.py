"""``pathgene compare``."""

from __future__ import annotations

import argparse
import dataclasses
import functools
import sys
from collections import Counter
from collections.abc import Generator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pathgene.host import interrupts
from pathgene.host.cli.arguments import (
    Commands,
    add_command,
    add_option,
    add_options,
    add_own_options,
    add_problem,
    complete_by_file,
)
from pathgene.host.cli.drawing import import_quickly
from pathgene.host.cli.output import (
    note,
    note_compiling,
    note_readings,
    note_start,
    print_json,
    print_pairs,
    print_table,
)
from pathgene.host.cli.values import complete_options, own_options, source_of
from pathgene.host.errors import InputError, JobError
from pathgene.host.files.output import prepare_directory
from pathgene.host.machine import available_cores
from pathgene.host.options.table import NAMED, SEARCH, options_of
from pathgene.host.planners import PLANNERS
from pathgene.host.report.routes import route_from
from pathgene.host.workers import LOCAL


if TYPE_CHECKING:
    from pathgene.host.compare.entrants import Entrant
    from pathgene.host.compare.report import Field
    from pathgene.host.compare.runs import Outcome, Task
    from pathgene.host.problem.problem import Problem


__all__ = ["add", "run"]

_MOST_RUNS = 100_000
# A p-value below this is printed as a bound.
_SMALLEST_P = 1e-99


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "compare",
        run,
        "Compare planners over many seeds",
        "pathgene compare --planners ga-fpga,ga-pc,ga-pc:max_waypoints=8 --terrain tile.tif "
        "--start 1200,1200,100 --goal 14000,14000,100 --agl --runs 5 --generations 20 "
        "--out out/compare",
        usage="[PROBLEM.toml] --planners NAME,... [OPTIONS]",
    )
    add_problem(parser)
    group = parser.add_argument_group("comparison")
    group.add_argument(
        "--planners",
        metavar="NAME[:KEY=VALUE]...,...",
        required=True,
        help=f"some of {', '.join(PLANNERS)}; options of one entry alone follow its name, as in "
        "ga-pc:max_waypoints=8:generations=500; a planner may be listed several times",
    )
    group.add_argument(
        "--runs",
        type=int,
        metavar="N",
        default=50,
        help="runs of each planner, with consecutive seeds (default %(default)s)",
    )
    add_option(group, NAMED["seed"], help="seed of the first run (default %(default)s)")
    group.add_argument(
        "--jobs",
        type=int,
        metavar="N",
        help="simultaneous runs, each in a process (default one per core)",
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS|local",
        nargs="?",
        const=LOCAL,
        help="run on the Dask cluster at this address, or on one started here for these runs "
        "(local, or no address); needs the extra pathgene[cluster]",
    )
    group = parser.add_argument_group("planning")
    add_options(group, options_of("search"))
    add_own_options(parser)
    group = parser.add_argument_group("output")
    add_option(
        group,
        NAMED["out"],
        default="out/compare",
        help="directory to write to; runs that it already holds are not repeated "
        "(default %(default)s)",
    )
    complete_by_file(parser, besides=("planners", "runs", "seed", "jobs", "scheduler", "out"))


def run(args: argparse.Namespace) -> int:
    """Execute the missing runs, write the report and print its tables."""
    note_start("Reading the problem.")
    from pathgene.host.compare.entrants import parse_entrants, planner_names, problem_digest
    from pathgene.host.compare.report import document, write_report
    from pathgene.host.compare.session import complete, kept
    from pathgene.host.compare.store import RunStore

    complete_options(args)
    entrants = parse_entrants(
        args.planners,
        {name: getattr(args, name) for name in SEARCH},
        own_options(args, *planner_names(args.planners)),
    )
    seeds = _seeds(args, entrants)
    jobs = _jobs(args, entrants)
    problem = _problem(args)
    directory = Path(args.out)
    prepare_directory(directory)
    if args.scheduler is None:
        note_compiling(as_paper=problem.as_paper)
    with RunStore(directory, problem_digest(problem)) as store:
        fields = kept(store, entrants, seeds)
        report = functools.partial(document, problem, source_of(args), fields, seeds)
        execute = functools.partial(_execute, problem, args.scheduler, jobs)
        try:
            try:
                complete(fields, seeds, store, execute, sys.stderr)
            except KeyboardInterrupt:
                if any(part.records for part in fields):
                    _write_interrupted(directory, report(interrupted=True))
                raise
            if any(part.records for part in fields):
                table = report()
                import_quickly()
                written = [store.path, *write_report(directory, table, warn=note)]
                if args.json:
                    print_json(table)
                else:
                    _print(table, written)
        except KeyboardInterrupt:
            done = sum(len(part.records) for part in fields)
            note(
                f"Interrupted; {done} of {len(fields) * len(seeds)} runs are kept in "
                f"{store.path}; repeat the command to continue."
            )
            return interrupts.status()
    return _status(fields, seeds)


def _problem(args: argparse.Namespace) -> Problem:
    from pathgene.host.mission.build import mission_of

    mission = mission_of(vars(args), say=note_readings)
    if mission.legs > 1:
        raise InputError("Only single legs can be compared; leave via points and return out.")
    return mission.problem


def _write_interrupted(directory: Path, table: dict[str, Any]) -> None:
    """Write the report of a comparison that ends early, if the disk accepts it."""
    from pathgene.host.compare.report import write_report

    try:
        write_report(directory, table, warn=note, picture=False)
    except InputError as error:
        note(str(error))


def _execute(
    problem: Problem, scheduler: str | None, jobs: int, tasks: Sequence[Task]
) -> Generator[Outcome]:
    from pathgene.host.compare.runs import run_in_processes, run_on_cluster

    jobs = min(jobs, len(tasks))
    if scheduler is None:
        return run_in_processes(problem, tasks, jobs)
    return run_on_cluster(problem, tasks, scheduler, jobs)


def _seeds(args: argparse.Namespace, entrants: Sequence[Entrant]) -> range:
    if not 1 <= args.runs <= _MOST_RUNS:
        raise InputError(f"The number of runs must be from 1 to {_MOST_RUNS:,}, not {args.runs}.")
    for seed in (args.seed, args.seed + args.runs - 1):
        dataclasses.replace(entrants[0].options, seed=seed)  # Refuses a bad one.
    return range(args.seed, args.seed + args.runs)


def _jobs(args: argparse.Namespace, entrants: Sequence[Entrant]) -> int:
    """Return the number of simultaneous runs: one per core, but only one on hardware."""
    if args.jobs is not None and args.jobs < 1:
        raise InputError(f"The number of jobs must be 1 or more, not {args.jobs}.")
    on_boards = [entrant.label for entrant in entrants if entrant.has_hardware]
    if on_boards and args.scheduler is not None:
        raise InputError(
            f"{on_boards[0]}: a board at this machine cannot be reached from a "
            "cluster; leave --scheduler out."
        )
    if on_boards and (args.jobs or 1) > 1:
        raise InputError(f"{on_boards[0]}: a board serves one run at a time; give --jobs 1.")
    if args.jobs is not None and args.scheduler not in (None, LOCAL):
        note("--jobs means nothing to a cluster, which has its own workers, and is ignored.")
    return args.jobs or (1 if on_boards else available_cores())


def _status(fields: Sequence[Field], seeds: Sequence[int]) -> int:
    """Report each reason of a failure once; return the exit status."""
    failures = [outcome for part in fields for outcome in part.failures.values()]
    reasons = Counter((outcome.task.entrant.label, outcome.failure) for outcome in failures)
    for (label, reason), count in reasons.items():
        note(f"{label}: {count} of {len(seeds)} runs failed: {reason}")
    if failures and all(outcome.bad_input for outcome in failures):
        return InputError.exit_status
    return JobError.exit_status if failures else 0


def _print(report: dict[str, Any], written: Sequence[Path]) -> None:
    print_table(
        [
            ("planner", "runs", "feasible", "mean F", "std", "best F", "seconds", "evaluations"),
            *(_row(planner["label"], planner["statistics"]) for planner in report["planners"]),
        ]
    )
    print()
    if report["pairs"]:
        print_table(
            [
                ("pair", "difference of means", "Welch p", "Mann-Whitney p", "first better"),
                *(_pair_row(pair) for pair in report["pairs"]),
            ]
        )
        print()
    print(_explanation(report))
    print()
    print_pairs([("written", str(path)) for path in written])


def _row(label: str, statistics: dict[str, Any]) -> tuple[str, ...]:
    fitness = statistics["fitness"]
    return (
        label,
        str(statistics["runs"]),
        _number(statistics["feasible_share"], ".0%"),
        *(_number(fitness[key], ".4f") for key in ("mean", "std", "best")),
        _number(statistics["seconds"]["mean"], ".3f"),
        _number(statistics["evaluations"], ".0f"),
    )


def _pair_row(pair: dict[str, Any]) -> tuple[str, ...]:
    return (
        " - ".join(pair["planners"]),
        _number(pair["mean_difference"], "+.4f"),
        _p_value(pair["welch"]),
        _p_value(pair["mann_whitney"]),
        _number(pair["superiority"], ".0%"),
    )


def _number(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def _p_value(test: dict[str, Any]) -> str:
    if test["p"] is None:
        return f"({test['note']})"
    return f"<{_SMALLEST_P:g}" if test["p"] < _SMALLEST_P else f"{test['p']:.2g}"


def _explanation(report: dict[str, Any]) -> str:
    first, last = report["seeds"]
    lines = [
        "F of all runs, infeasible ones included; feasible by the strict rule; seconds and "
        "evaluations are means.",
        f"Seeds {first} to {last} for every planner. Planners draw different numbers from the "
        "same seed: runs are not paired.",
    ]
    for planner in report["planners"]:
        routes = [route_from(run) for run in planner["runs"]]
        if count := sum(route is not None and "astar" in route for route in routes):
            lines.append(
                f"{planner['label']}: the path is the route of astar in {count} of "
                f"{len(routes)} runs; :polish=chip compares the chip's own."
            )
    if report["pairs"]:
        lines.append(
            "p two-sided"
            + (
                f", not corrected for the {len(report['pairs'])} pairs"
                if len(report["pairs"]) > 1
                else ""
            )
            + "; first better: chance that a run of the "
            "first is better than one of the second."
        )
    return "\n".join(lines)
