"""The default planner compared with ``astar`` and peers on the nine maps of ``quality``.

The columns are as in :mod:`bench.untuned`. Seven of the maps are real, and constants of the
planner core were chosen on the nine.
"""

from __future__ import annotations

import dataclasses
import importlib.util

from bench.campaign import measure
from bench.report import Options, Report
from bench.scenarios import SYNTHETIC, missing, names, problem
from bench.untuned import RULES, Outcome, outcome_of, prepare, table
from pathgene.host.problem.rules import Rules


def run(options: Options) -> Report:
    """Plan over every available map by every planner, in paper mode and with a clearance."""
    has_peers = importlib.util.find_spec("ompl") is not None
    maps = [name for name in (*names(), *SYNTHETIC) if options.only in name]
    tasks = [(name, clearance_m, has_peers) for clearance_m in RULES.values() for name in maps]
    outcomes = measure(
        "real-maps",
        tasks,
        plan,
        name=lambda task: f"{task[0]}, clearance {task[1]}",
        prepare=prepare,
        spawned=True,
    )
    found = dict(zip(tasks, outcomes, strict=True))
    reports = [
        table(
            f"nine maps, {title}",
            {name: [found[name, clearance_m, has_peers]] for name in maps},
            has_peers,
            "terrain",
        )
        for title, clearance_m in RULES.items()
    ]
    reports[0].notes += missing()
    if not has_peers:
        reports[0].notes.append("OMPL is not installed: no peers (pip install '.[peers]').")
    reports[0].data = {
        "outcomes": [
            {"map": name, "clearance_m": clearance_m, **dataclasses.asdict(outcome)}
            for (name, clearance_m, _), outcome in found.items()
        ]
    }
    return dataclasses.replace(reports[0], further=reports[1:])


def plan(
    name: str, clearance_m: float | None, has_peers: bool, generations: int | None = None
) -> Outcome:
    """Return the outcome of all planners over a map."""
    rules = None if clearance_m is None else Rules(clearance_m=clearance_m)
    return outcome_of(dataclasses.replace(problem(name), rules=rules), has_peers, generations)
