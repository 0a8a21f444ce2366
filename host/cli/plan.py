"""``pathgene plan``."""

from __future__ import annotations

import argparse
import contextlib
import shutil
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pathgene.host import interrupts
from pathgene.host.cli.arguments import (
    Commands,
    add_command,
    add_end,
    add_options,
    add_own_options,
    add_problem,
    complete_by_file,
)
from pathgene.host.cli.beside import plan_beside, print_beside, row_of, searches_beside
from pathgene.host.cli.drawing import import_quickly
from pathgene.host.cli.ending import ending
from pathgene.host.cli.output import (
    note,
    note_compiling,
    note_readings,
    note_start,
    print_json,
    print_pairs,
    term_pairs,
)
from pathgene.host.cli.values import complete_options, own_options, save_options, source_of
from pathgene.host.errors import InputError, JobError
from pathgene.host.files.output import prepare_directory
from pathgene.host.formats.registry import check_formats, parse_formats
from pathgene.host.options.table import SEARCH, options_of
from pathgene.host.progress import Progress
from pathgene.host.report.routes import route_from, route_note, route_pairs
from pathgene.host.stages import watched_by


if TYPE_CHECKING:
    from pathgene.host.mission.autopilot.hand_over import HandOver
    from pathgene.host.mission.ending import Ending
    from pathgene.host.planning import Plan
    from pathgene.host.report.write import Written


__all__ = ["add", "run"]


def add(commands: Commands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "plan",
        run,
        "Plan a path and write it with a summary and a picture",
        "pathgene plan --terrain tile.tif --start 1200,1200,100 --goal 14000,14000,100 --agl "
        "--nofly-circle 7000,7000,900 --board sim: --out out",
        usage="[PROBLEM.toml] [OPTIONS]",
        notes="The exit status is 0 with a feasible path, 1 without one or if a file is missing "
        "because no autopilot can fly the mission safely, 2 for bad input.",
    )
    add_problem(parser)
    group = parser.add_argument_group("planning")
    add_options(group, options_of("search", "planning"))
    group.add_argument(
        "--beside",
        metavar="NAME,...",
        help="planners to run afterwards on the same problem, for a table of all; none of their "
        "paths is written",
    )
    add_own_options(parser)
    add_end(parser.add_argument_group("end of the mission"))
    group = parser.add_argument_group("output")
    add_options(group, options_of("output"))
    group.add_argument(
        "--save-problem",
        metavar="FILE",
        help="write a problem file, .toml, of these options before planning",
    )
    complete_by_file(parser, besides=("beside", "save_problem"))


def run(args: argparse.Namespace) -> int:
    """Plan, write the files and print the summary."""
    note_start("Reading the problem.")
    from pathgene.host.mission.autopilot.hand_over import hand_over_of
    from pathgene.host.mission.build import mission_of, planner_of
    from pathgene.host.mission.ending import LOITER, ending_of
    from pathgene.host.mission.planning import plan_mission
    from pathgene.host.planners.base import Stop
    from pathgene.host.planning import Search

    complete_options(args)
    args.planner = planner_of(vars(args))
    search = Search(
        args.planner,
        **{option.field: getattr(args, name) for name, option in SEARCH.items()},
        seed=args.seed,
        fallback=args.fallback,
        **own_options(args, args.planner),
    )
    searches = searches_beside(args)
    formats = parse_formats(args.write) if args.write else ()
    wanted = hand_over_of(vars(args))
    mission = mission_of(vars(args), say=note_readings)
    check_formats(formats, mission.problem.terrain)
    end = ending_of(vars(args), mission.problem)
    if "html" in formats:
        from pathgene.host.web.page import require_library

        require_library()
    if args.save_problem is not None:
        save_options(args, Path(args.save_problem))
    directory = Path(args.out)
    prepare_directory(directory)

    note_compiling(as_paper=mission.problem.as_paper)
    stop = Stop()
    with ending(stop):
        # Every leg has a generation 0.
        generations = mission.legs * (search.options.generations + 1) - 1
        try:
            with (
                contextlib.closing(Progress(sys.stderr, generations)) as progress,
                watched_by(progress.stage),
            ):
                plan = plan_mission(
                    mission, search, progress=progress.update, stop=stop, source=source_of(args)
                )
        except (KeyboardInterrupt, JobError) as error:
            # A signal to the process group also ends child processes, such as a compiler.
            if isinstance(error, JobError) and not stop.requested:
                raise
            note(f"Interrupted before a path was found; nothing is written to {directory}.")
            return interrupts.status()
        if plan.fallback is not None:
            note(f"{plan.planner} found no feasible path; the path was found by {plan.fallback}.")
        wanted = replace(wanted, ending=end or LOITER)
        others, missing = _others(plan, formats, wanted)
        written, summary = _save(args, plan, end, others, directory)
        width = 0
        try:
            if not args.json:
                width = print_pairs(_pairs(summary, written))
            elif not searches:
                print_json(summary)
            sys.stdout.flush()
        finally:  # Also if nobody reads the output.
            drawn = _draw(plan, end, directory, wanted) if args.picture else []
        if drawn and not args.json:
            print_pairs([("written", str(path)) for path in drawn], width)
    rows = []
    if searches and not plan.interrupted:
        try:
            rows = [row_of(plan), *plan_beside(args, mission, searches)]
        except KeyboardInterrupt:
            note("Interrupted; the plan is written.")
            return interrupts.status()
    if args.json and searches:
        print_json({**summary, "beside": rows} if rows else summary)
    elif rows:
        print()
        print_beside(rows)
    return _status(plan, missing)


def _save(
    args: argparse.Namespace,
    plan: Plan,
    end: Ending | None,
    others: Mapping[str, bytes],
    directory: Path,
) -> Written:
    """Write all files but the picture; if that fails, keep them in a temporary folder and say so.

    The picture is drawn once the result is printed, because it takes longer than a quick plan.
    """
    from pathgene.host.mission.ending import with_end
    from pathgene.host.report.write import write_report

    def write(folder: Path) -> Written:
        return write_report(
            folder,
            plan.evaluator,
            plan.result,
            with_end(plan.summary, end),
            note,
            picture=False,
            grid=args.grid,
            others=others,
        )

    try:
        return write(directory)
    except InputError as error:
        try:
            folder = Path(tempfile.mkdtemp(prefix="pathgene-"))
        except OSError:
            raise error from None
        try:
            write(folder)
        except InputError:
            shutil.rmtree(folder, ignore_errors=True)
            raise error from None
        raise InputError(
            f"{str(error).rstrip('.')}; this plan is kept in {str(folder)!r}."
        ) from None


def _draw(plan: Plan, end: Ending | None, directory: Path, wanted: HandOver) -> list[Path]:
    """Draw the picture and return its file, or nothing after a failure, which is noted."""
    import_quickly()
    from pathgene.host.mission.drawn import mission_of_plan
    from pathgene.host.mission.ending import with_end
    from pathgene.host.report.write import write_run_picture

    return write_run_picture(
        directory,
        plan.evaluator,
        plan.result,
        with_end(plan.summary, end),
        note,
        lambda: mission_of_plan(plan, wanted),
    )


def _others(
    plan: Plan, formats: Sequence[str], wanted: HandOver
) -> tuple[dict[str, bytes], str | None]:
    """Return the files that ``--write`` names, by name, and the reason why some are missing."""
    from pathgene.host.mission.export import exported_with_room

    def page() -> str:
        from pathgene.host.web.page import page_of

        return page_of(plan.evaluator, plan.path, plan.summary, wanted)

    return exported_with_room(
        plan.evaluator.problem,
        plan.path,
        [name for name in formats if name != "geojson"],  # Every run has it.
        note,
        feasible=plan.evaluation.feasible,
        page=page,
        wanted=wanted,
    )


def _status(plan: Plan, missing: str | None) -> int:
    """Return the exit status; raise the error of a failed job, whose files are written.

    Parameters
    ----------
    missing : str or None
        The reason why files are missing that were asked for.
    """
    from pathgene.host.mission.legs import shortcoming

    result = plan.result
    if result.interrupted:
        note("Interrupted; the best path so far is written.")
        return interrupts.status()
    if result.failure is not None:
        raise JobError(f"{result.failure.rstrip('.')}; the best path until then is written.")
    sentence = shortcoming(plan.summary)
    if sentence is not None:
        if missing is not None:
            note(missing)
        raise JobError(f"{sentence.rstrip('.')}; the best path is written.")
    if missing is not None:
        raise JobError(f"{missing.rstrip('.')}, but all other files are.")
    return 0


def _pairs(summary: dict[str, Any], written: list[Path]) -> list[tuple[str, str]]:
    return [
        ("planner", summary["planner"]),
        ("board", summary["board"] or "none"),
        *([("fallback", summary["fallback"])] if summary["fallback"] else []),
        *route_pairs(summary),
        *_legs(summary),
        *term_pairs(summary),
        ("generations", f"{summary['generations']}"),
        ("evaluations", f"{summary['evaluations']}"),
        *_counted(summary["hardware"] or {}),
        ("time", f"{summary['seconds']['total']:.2f} s"),
        *(("written", str(path)) for path in written),
    ]


def _legs(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the legs of a mission with their lengths."""
    return [
        (
            f"leg {leg['index']}",
            f"{leg['name'].partition(', ')[2]}: "
            + (
                f"{'feasible' if leg['feasible'] else 'not feasible'}, {leg['length_m']:.1f} m"
                + (f", {said}" if (said := route_note(route_from(leg))) else "")
                if leg["planned"]
                else "not planned"
            ),
        )
        for leg in summary.get("legs", ())
    ]


def _counted(hardware: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the work and the savings of the board's collision checker, if it was used."""
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
