"""Planners that ``pathgene plan --beside`` runs on the same problem, and their table."""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pathgene.host.cli.ending import ending
from pathgene.host.cli.output import note, print_table
from pathgene.host.cli.values import source_of
from pathgene.host.errors import InputError, PathgeneError
from pathgene.host.options.table import OWN, SEARCH
from pathgene.host.planners import DEFAULT_BOARD, PLANNERS
from pathgene.host.progress import Progress
from pathgene.host.report.routes import route_from, route_note
from pathgene.host.stages import watched_by


if TYPE_CHECKING:
    from pathgene.host.mission.mission import MissionProblem
    from pathgene.host.planning import Plan, Search


__all__ = ["plan_beside", "print_beside", "row_of", "searches_beside"]


def searches_beside(args: argparse.Namespace) -> list[Search]:
    """Return a search for each planner of ``--beside`` except the planner of the command itself.

    They get those options of the command that they know, and have no fallback. If the board only
    serves the planner of the command, they use the software model.

    Raises
    ------
    InputError
        If there is no such planner, a name is empty, or an option is bad.
    """
    if not args.beside:
        return []
    names = [name.strip() for name in args.beside.split(",")]
    if "" in names:
        raise InputError(
            f"--beside has an empty name in {args.beside!r}; put one comma between two planners."
        )
    return [_search(args, name) for name in dict.fromkeys(names) if name != args.planner]


def _search(args: argparse.Namespace, name: str) -> Search:
    from pathgene.hdl.config import GeneticCore
    from pathgene.host.device.boards import with_core
    from pathgene.host.planning import Search

    having = PLANNERS[name].options if name in PLANNERS else ()
    own = {option: getattr(args, option) for option in OWN if option in having}
    # Hardware, and a board whose URL names a core, has only that core.
    if args.board is not None and with_core(args.board, GeneticCore.PAPER) == args.board:
        own = {option: DEFAULT_BOARD if option == "board" else own[option] for option in own}
    return Search(
        name,
        **{option.field: getattr(args, name) for name, option in SEARCH.items()},
        seed=args.seed,
        **own,
    )


def plan_beside(
    args: argparse.Namespace, mission: MissionProblem, searches: Sequence[Search]
) -> list[dict[str, Any]]:
    """Plan with each search in turn; return a row of the table for each, see :func:`row_of`.

    A failure is noted and gets no row.

    Raises
    ------
    KeyboardInterrupt
        If the user interrupts it.
    """
    from pathgene.host.mission.planning import plan_mission
    from pathgene.host.planners.base import Stop

    rows = []
    for search in searches:
        where = "" if search.board is None else f" on {search.board}"
        note(f"Beside it, {search.planner}{where}.")
        stop = Stop()
        generations = mission.legs * (search.options.generations + 1) - 1
        try:
            with (
                ending(stop),
                contextlib.closing(Progress(sys.stderr, generations)) as progress,
                watched_by(progress.stage),
            ):
                plan = plan_mission(
                    mission, search, progress=progress.update, stop=stop, source=source_of(args)
                )
        except PathgeneError as error:
            note(f"{search.planner}: {error}")
            continue
        if plan.interrupted:
            raise KeyboardInterrupt
        if plan.failure is not None:
            note(f"{search.planner}: {plan.failure}")
        rows.append(row_of(plan))
    return rows


def row_of(plan: Plan) -> dict[str, Any]:
    """Return the row of a plan in the table; ``plan_us`` is None unless only the chip planned."""
    summary = plan.summary
    legs = [leg for leg in summary.get("legs", ()) if leg["planned"]]
    parts = [part["hardware"] or {} for part in legs or (summary,)]
    return {
        "planner": summary["planner"],
        "fallback": summary["fallback"],
        "route_from": route_from(summary),
        "board": summary["board"],
        "feasible": summary["feasible"],
        "fitness": summary["fitness"],
        "plan_us": sum(part["plan_us"] for part in parts)
        if parts and all("plan_us" in part for part in parts)
        else None,
        "clock_hz": parts[0].get("clock_hz") if parts else None,
        "seconds": summary["seconds"]["total"],
    }


def print_beside(rows: Sequence[Mapping[str, Any]]) -> None:
    """Print the table."""
    print_table(
        [
            ("planner", "board", "feasible", "fitness", "time of the chip", "seconds"),
            *(
                (
                    ", ".join(
                        filter(
                            None, (row["planner"], row["fallback"], route_note(row["route_from"]))
                        )
                    ),
                    row["board"] or "none",
                    "yes" if row["feasible"] else "no",
                    f"{row['fitness']:.4f}",
                    "-"
                    if row["plan_us"] is None
                    else f"{row['plan_us']:,.0f} us at {row['clock_hz'] / 1e6:g} MHz",
                    f"{row['seconds']:.2f}",
                )
                for row in rows
            ),
        ]
    )
    print("Seconds are measured on this computer and include the simulation of a board.")
