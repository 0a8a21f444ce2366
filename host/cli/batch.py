"""``pathgene batch``."""

from __future__ import annotations

import argparse
import contextlib
import copy
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pathgene.host import interrupts
from pathgene.host.cli.arguments import (
    Commands,
    add_command,
    add_option,
    add_options,
    add_own_options,
    leave_unset,
)
from pathgene.host.cli.drawing import import_quickly
from pathgene.host.cli.output import (
    note,
    note_compiling,
    note_reading,
    note_start,
    print_json,
    print_pairs,
    print_table,
)
from pathgene.host.cli.values import file_values, ignored_options
from pathgene.host.errors import InputError, JobError
from pathgene.host.files.output import prepare_directory, write_json, writing_into
from pathgene.host.machine import available_cores
from pathgene.host.options.table import NAMED, ZONE_READING, options_of
from pathgene.host.progress import Bar
from pathgene.host.report.routes import route_from, route_note
from pathgene.host.workers import LOCAL


if TYPE_CHECKING:
    from pathgene.host.mission.batch import Job, Outcome


__all__ = ["add", "run"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "batch",
        run,
        "Plan many problem files, in several processes or on a Dask cluster",
        "pathgene batch north.toml south.toml --jobs 2 --out out/batch",
        usage="PROBLEM.toml... [OPTIONS]",
        notes="The exit status is 0 if every problem has a feasible path, 2 if bad input alone is "
        "to blame, 1 otherwise.",
    )
    parser.add_argument(
        "problems", metavar="PROBLEM.toml", nargs="+", help="problem files; see pathgene problem"
    )
    group = parser.add_argument_group("planning, instead of the files' own options")
    add_options(group, [*options_of("search", "planning"), NAMED["as_paper"]])
    add_options(group, ZONE_READING)
    add_own_options(parser)
    group = parser.add_argument_group("execution")
    group.add_argument(
        "--jobs",
        type=int,
        metavar="N",
        help="problems planned at a time, each in a process (default one per core)",
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS|local",
        nargs="?",
        const=LOCAL,
        help="plan on the Dask cluster at this address, or on one started here (local, or no "
        "address); needs the extra pathgene[cluster]",
    )
    group = parser.add_argument_group("output")
    add_option(
        group,
        NAMED["out"],
        default="out/batch",
        help="directory to write to, a folder for each problem; a problem whose result it holds is "
        "not planned again (default %(default)s)",
    )
    add_options(group, [NAMED["picture"], NAMED["grid"]])
    leave_unset(parser, besides=("problems", "jobs", "scheduler", "out"))


def run(args: argparse.Namespace) -> int:
    """Plan the problems without a result, write ``batch.json`` and print a table."""
    note_start("Reading the problems.")
    from pathgene.host.mission.batch import kept_summary, names_of
    from pathgene.host.report.summary import version

    if args.jobs is not None and args.jobs < 1:
        raise InputError(f"The number of jobs must be 1 or more, not {args.jobs}.")
    if args.jobs is not None and args.scheduler not in (None, LOCAL):
        note("--jobs means nothing to a cluster, which has its own workers, and is ignored.")
    directory = Path(args.out)
    rows: list[dict[str, Any]] = []
    jobs: list[Job] = []
    for name, file in zip(names_of(args.problems), args.problems, strict=True):
        rows.append({"name": name, "file": file})
        try:
            jobs.append(_job(args, name, file))
        except InputError as error:
            rows[-1] |= _failed(str(error), bad_input=True)
    prepare_directory(directory)
    by_name = {row["name"]: row for row in rows}
    missing = []
    for job in jobs:
        summary = kept_summary(directory, job)
        if summary is None:
            missing.append(job)
        else:
            note_reading(summary.get("read"), f"{job.name}: ")
            by_name[job.name] |= {"kept": True, **_terms(summary)}
    try:
        _plan(args, directory, missing, by_name, kept=len(jobs) - len(missing))
    except KeyboardInterrupt:
        done = sum("feasible" in row for row in rows)
        note(
            f"Interrupted; {done} of {len(rows)} problems are kept in {directory}; repeat the "
            "command to continue."
        )
        return interrupts.status()
    report = {"pathgene": version(), "problems": rows}
    with writing_into(directory):
        write_json(directory / "batch.json", report)
    if args.json:
        print_json(report)
    else:
        _print(rows, directory)
    return _status(rows)


def _job(args: argparse.Namespace, name: str, file: str) -> Job:
    """Return the job of a problem file and the options; note options that its planner lacks."""
    from pathgene.host.mission.batch import Job
    from pathgene.host.mission.build import planner_of

    own = copy.copy(args)
    own.problem = file
    given = {name: getattr(args, name) for name in args.option_defaults if name in vars(args)}
    values = {**file_values(own), **given}
    planner = planner_of(values)
    for option in ignored_options(values, planner):
        note(f"{name}: {option} means nothing to {planner} and is ignored.")
    # Then the board need not be queried again, and results of another default planner are not
    # mistaken for results of this one.
    return Job(name, file, {**values, "planner": planner})


def _plan(
    args: argparse.Namespace,
    directory: Path,
    jobs: Sequence[Job],
    rows: Mapping[str, dict[str, Any]],
    kept: int,
) -> None:
    """Plan jobs; complete their rows, and save each result immediately."""
    from pathgene.host.mission.batch import execute

    if not jobs:
        return
    count = args.jobs or (1 if any(map(_on_hardware, jobs)) else available_cores())
    if count > 1 and args.scheduler is None and any(map(_on_hardware, jobs)):
        raise InputError("A board serves one run at a time; give --jobs 1.")
    if args.scheduler is None:
        note_compiling(as_paper=all(job.values.get("as_paper") for job in jobs))
    total = kept + len(jobs)
    bar = Bar(sys.stderr, total)
    with (
        contextlib.closing(bar),
        contextlib.closing(execute(jobs, count, args.scheduler)) as outcomes,
    ):
        bar.show(kept, f"problem {kept}/{total}")
        for done, (job, outcome) in enumerate(outcomes, start=kept + 1):
            with interrupts.held():  # A result that has arrived counts, too.
                rows[job.name].update(_saved(directory, job, outcome))
            refused = "" if outcome.summary is not None else ", not planned"
            bar.show(done, f"problem {done}/{total}  {job.name}{refused}")


def _saved(directory: Path, job: Job, outcome: Outcome) -> dict[str, Any]:
    from pathgene.host.mission.batch import save

    if job.values.get("picture") is not False:
        import_quickly()
    if outcome.summary is None:
        note_reading(outcome.read, f"{job.name}: ")
        return _failed(outcome.failure or "It failed.", bad_input=outcome.bad_input)
    note_reading(outcome.summary.get("read"), f"{job.name}: ")
    save(directory, job, outcome, note)
    return {"kept": False, **_terms(outcome.summary)}


def _on_hardware(job: Job) -> bool:
    from pathgene.host.device.boards import known_config

    board = job.values.get("board")
    return board is not None and known_config(board) is None


def _terms(summary: Mapping[str, Any]) -> dict[str, Any]:
    from pathgene.host.mission.legs import shortcoming
    from pathgene.host.report.reading import warnings_in

    return {
        "feasible": bool(summary["feasible"]),
        "planner": summary["planner"],
        "fallback": summary["fallback"],
        "route_from": route_from(summary),
        "fitness": summary["fitness"],
        "length_m": summary["length_m"],
        "legs": len(summary.get("legs") or (None,)),
        "seconds": summary["seconds"]["total"],
        "failure": summary["failure"] or shortcoming(summary),
        "bad_input": False,
        "warnings": warnings_in(summary),
    }


def _failed(sentence: str, *, bad_input: bool) -> dict[str, Any]:
    return {"kept": False, "feasible": False, "failure": sentence, "bad_input": bad_input}


def _status(rows: Sequence[Mapping[str, Any]]) -> int:
    # A path that misses a via point may be feasible and is still a failure.
    failures = [row for row in rows if row["failure"] is not None]
    for row in failures:
        note(f"{row['name']}: {row['failure']}")
    if failures and all(row["bad_input"] for row in failures):
        return InputError.exit_status
    return JobError.exit_status if failures else 0


def _remark(row: Mapping[str, Any]) -> str:
    """Return the remark of a row: the planner of the path, and whether the path is kept."""
    by = f"by {row['fallback']}" if row["fallback"] else ""
    return ", ".join(
        filter(None, (by, route_note(row["route_from"]), "kept" if row["kept"] else ""))
    )


def _print(rows: Sequence[Mapping[str, Any]], directory: Path) -> None:
    table = [("problem", "feasible", "fitness", "length", "legs", "seconds", "")]
    for row in rows:
        if "fitness" not in row:
            table.append((row["name"], "failed", "-", "-", "-", "-", ""))
            continue
        table.append(
            (
                row["name"],
                "yes" if row["feasible"] else "no",
                f"{row['fitness']:.4f}",
                f"{row['length_m'] / 1000:.2f} km",
                str(row["legs"]),
                f"{row['seconds']:.2f}",
                _remark(row),
            )
        )
    print_table(table)
    print()
    print_pairs([("written", str(directory / "batch.json"))])
