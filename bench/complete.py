"""Problems that are solvable by construction: how many of them the planners solve.

See :mod:`bench.planted`. The default planner is counted twice: alone, and with the searches that
follow when it finds no path.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from itertools import filterfalse
from statistics import mean
from typing import Any

from bench.campaign import measure
from bench.planted import CLAIMED, FAMILIES, TUNING, planted
from bench.report import Options as BenchOptions
from bench.report import Report
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planning import Plan, Search


#: Planners whose paths are counted.
PLANNERS = ("astar", "ga-chip")
_DEFAULT = "ga-chip"

Outcome = dict[str, Any]


def run(options: BenchOptions) -> Report:
    """Plan the problems of every family by the planners.

    Raises
    ------
    InputError
        If no family has the text of ``options.only`` in its name.
    """
    families = [name for name in FAMILIES if options.only in name]
    if not families:
        raise InputError(
            f"No family has {options.only!r} in its name; there are {', '.join(FAMILIES)}."
        )
    seeds = (CLAIMED if options.claimed else TUNING)[: options.seeds]
    tasks = [(family, seed) for family in families for seed in seeds]
    outcomes = measure("complete", tasks, solve, name=lambda task: task[0], prepare=_compile)
    found: dict[str, list[Outcome]] = {name: [] for name in families}
    for (family, _), outcome in zip(tasks, outcomes, strict=True):
        found[family].append(outcome)
    kind = "claimed seeds, not used while tuning" if options.claimed else "tuning seeds"
    report = Report(
        f"Planted problems that are solved, of {len(seeds)} each, {kind}",
        (
            "family",
            "astar",
            "ga-chip alone",
            "guided",
            "ga-chip and fallbacks",
            "by astar",
            "by fpa-2opt",
            "CPU s, astar",
            "longest",
            "CPU s, ga-chip",
        ),
        [(name, *row(some)) for name, some in found.items()],
        notes=[
            "Each problem is solvable: the strict rule accepts a path that was planted before "
            "ground and zones were built around it. Solved: a path is feasible by the strict rule. "
            "Ga-chip alone: a path of the chip is feasible, with the host's polish. Guided: how "
            "many of these after a run that began along the path of astar. By astar, by fpa-2opt: "
            "problems that only the fallback solved. Plans of seed 0, with all options at their "
            "defaults, on the chip's model. Processor seconds of a plan, compiling not counted, "
            "fallbacks included."
        ],
    )
    report.rows.append(("all", *row(outcomes)))
    report.data = {"exceptions": {name: list(filterfalse(_usual, found[name])) for name in found}}
    return report


def row(outcomes: Sequence[Outcome]) -> tuple[object, ...]:
    """Return the cells of a family."""
    astar, chip = ([outcome[planner] for outcome in outcomes] for planner in PLANNERS)
    fallbacks = [each["fallback"] for each in chip if each["feasible"]]
    alone = [each for each in chip if each["alone"]]
    seconds = [each["cpu_seconds"] for each in astar]
    return (
        sum(each["feasible"] for each in astar),
        len(alone),
        sum(each["guided"] for each in alone),
        len(fallbacks),
        len(fallbacks) - len(alone) - fallbacks.count("fpa-2opt"),
        fallbacks.count("fpa-2opt"),
        mean(seconds),
        max(seconds),
        mean(each["cpu_seconds"] for each in chip),
    )


def _usual(outcome: Outcome) -> bool:
    """Return whether ``astar`` and the chip alone have solved a problem."""
    astar, chip = (outcome[planner] for planner in PLANNERS)
    return bool(astar["feasible"] and chip["alone"])


def _compile() -> None:
    """Compile all code, or load it from the cache, before anything is timed."""
    for family in ("maze", "pit"):
        solve(family, TUNING[0])


def solve(family: str, seed: int) -> Outcome:
    """Return the outcome of each planner for a problem."""
    outcome: Outcome = {"seed": seed}
    for planner in PLANNERS:
        evaluator = Evaluator(planted(family, seed).problem, threads=1)
        search = Search(planner, fallback="astar" if planner == _DEFAULT else None)
        start = time.process_time()
        plan = search.run(evaluator)
        outcome[planner] = {
            "feasible": plan.evaluation.feasible,
            "fitness": plan.evaluation.fitness,
            "fallback": plan.fallback,
            "alone": planner == _DEFAULT and _found_by_chip(plan),
            "guided": any(run["guided"] for run in (plan.result.hardware or {}).get("runs", ())),
            "cpu_seconds": time.process_time() - start,
        }
    return outcome


def _found_by_chip(plan: Plan) -> bool:
    """Return whether a path of the chip is feasible, even if one of ``astar`` is better."""
    hardware = plan.result.hardware
    return plan.fallback is None and hardware is not None and hardware["routes"]["chip"] is not None
