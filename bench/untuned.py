"""The default planner compared with ``astar`` and peers on problems that nobody tuned for.

See :mod:`bench.generated`. A peer is a planner of OMPL, whose paths get our waypoints and lowest
altitudes, as the paths of ``ga-chip`` do, and the best of all its paths in the same seconds counts.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import time
from collections.abc import Callable, Mapping, Sequence
from statistics import mean
from typing import Any

from bench.campaign import measure
from bench.generated import CLAIMED, KINDS, TUNING, generated
from bench.peers.optimizers import PLANNERS as PEERS
from bench.peers.optimizers import solve
from bench.report import Options as BenchOptions
from bench.report import Report
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Result
from pathgene.host.planners.chip.polish import polished
from pathgene.host.planning import Search
from pathgene.host.problem.problem import Problem


_YARDSTICK, _DEFAULT = "astar", "ga-chip"
_PEER = "peers"
#: Our planners with their options, by the names of their columns; the default has its fallbacks.
VARIANTS: dict[str, tuple[str, dict[str, Any]]] = {
    _YARDSTICK: (_YARDSTICK, {}),
    _DEFAULT: (_DEFAULT, {"fallback": "astar"}),
    "chip alone, 10 ms": (_DEFAULT, {"chip_ms": 10, "polish": "chip"}),
    "chip alone, 10 ms, unpolished": (_DEFAULT, {"chip_ms": 10, "polish": "off"}),
}
#: Titles of the tables by the clearance; None stands for paper mode.
RULES = {"paper mode": None, "with a clearance of 30 m": 30.0}
# F below another's counts only beyond this.
_EQUAL = 1e-4

#: Kind, seed and clearance of a problem.
_Task = tuple[str, int, float | None]


@dataclasses.dataclass(frozen=True)
class Outcome:
    """F of each column, None without a feasible path; the route that won; processor seconds."""

    fitness: dict[str, float | None]
    route_from: str | None
    seconds: float

    def gain(self, column: str, rivals: Sequence[str]) -> float | None:
        """Return by how much F of a column exceeds the best rival's; None without either."""
        other = max((self.fitness.get(name) or 0.0 for name in rivals), default=0.0)
        own = self.fitness[column] or 0.0
        return own - other if own and other else None


def run(options: BenchOptions) -> Report:
    """Plan every problem by every planner, in paper mode and with a clearance."""
    seeds = (CLAIMED if options.claimed else TUNING)[: options.seeds]
    has_peers = importlib.util.find_spec("ompl") is not None
    tasks = [
        (kind, seed, clearance_m)
        for clearance_m in RULES.values()
        for kind in KINDS
        for seed in seeds
    ]
    outcomes = measure(
        "untuned",
        # OMPL takes as long as all our plans together, so one table has peers.
        [(task, has_peers and task[2] is None) for task in tasks],
        plan,
        name=lambda task: f"{task[0][0]}, clearance {task[0][2]}",
        prepare=prepare,
        spawned=True,
    )
    found = dict(zip(tasks, outcomes, strict=True))
    reports = []
    for title, clearance_m in RULES.items():
        kinds = {kind: [found[kind, seed, clearance_m] for seed in seeds] for kind in KINDS}
        claim = "claimed seeds, not used while tuning" if options.claimed else "tuning seeds"
        with_peers = has_peers and clearance_m is None
        reports.append(table(f"generated problems, {title}, {claim}", kinds, with_peers))
    if not has_peers:
        reports[0].notes.append("OMPL is not installed: no peers (pip install '.[peers]').")
    reports[0].data = {
        "outcomes": [
            {"kind": kind, "seed": seed, "clearance_m": clearance_m, **dataclasses.asdict(outcome)}
            for (kind, seed, clearance_m), outcome in found.items()
        ]
    }
    return dataclasses.replace(reports[0], further=reports[1:])


def table(
    title: str, kinds: Mapping[str, Sequence[Outcome]], has_peers: bool, first: str = "kind"
) -> Report:
    """Return the table of one set of rules: a row for each kind of problems, and one for all.

    ``first`` is the title of the column of kinds.
    """
    columns = [*VARIANTS, *([_PEER] if has_peers else ())]
    report = Report(
        f"Mean F on {title}",
        (
            first,
            "problems",
            *columns,
            "not feasible",
            "below astar",
            *(["below peers", "gain over the best"] if has_peers else ["gain over astar"]),
            "route of astar",
            "CPU s",
        ),
        notes=[
            "Mean F of the problems that all columns solve. Not feasible: problems in which "
            f"{_DEFAULT} has no feasible path, its fallbacks included. Below: problems whose F by "
            f"{_DEFAULT}, with all options at their defaults and seed 0, is below by more than "
            "0.0001. Gain: mean of "
            "its F less the best F of astar and the peers. Route of astar: problems whose "
            "reported path is its polished route. CPU seconds: mean of a plan by the default.",
            *(
                [
                    f"Peers: the best of OMPL's {', '.join(PEERS)}, each with as many seconds "
                    f"as {_DEFAULT} took, started again until they are over; every path is "
                    "simplified by OMPL and polished as the chip's."
                ]
                if has_peers
                else []
            ),
        ],
    )
    every = [outcome for some in kinds.values() for outcome in some]
    for name, some in (*kinds.items(), ("all", every)):
        report.rows.append((name, len(some), *_cells(some, columns)))
    return report


def _cells(some: Sequence[Outcome], columns: Sequence[str]) -> list[object]:
    """Return the cells of a kind after the number of its problems."""
    solved = [each for each in some if all(each.fitness[column] for column in columns)]
    means: list[object] = [
        f"{mean(each.fitness[column] or 0.0 for each in solved):.4f}" if solved else "-"
        for column in columns
    ]
    rivals = [_YARDSTICK, *([_PEER] if _PEER in columns else ())]
    gains = [each.gain(_DEFAULT, rivals) for each in some]
    known = [gain for gain in gains if gain is not None]
    return [
        *means,
        sum(each.fitness[_DEFAULT] is None for each in some),
        *(
            sum(
                (each.fitness[_DEFAULT] or 0.0) < (each.fitness[rival] or 0.0) - _EQUAL
                for each in some
            )
            for rival in rivals
        ),
        f"{mean(known):+.4f}" if known else "-",
        sum(each.route_from == _YARDSTICK for each in some),
        f"{mean(each.seconds for each in some):.2f}",
    ]


def plan(task: _Task, has_peers: bool, generations: int | None = None) -> Outcome:
    """Return the outcome of all planners for a generated problem."""
    return outcome_of(generated(*task), has_peers, generations)


def outcome_of(problem: Problem, has_peers: bool, generations: int | None = None) -> Outcome:
    """Return the outcome of all planners for a problem."""
    fitness: dict[str, float | None] = {}
    for name, (planner, own) in VARIANTS.items():
        evaluator = Evaluator(problem, threads=1)
        search = Search(planner, generations=generations, **own)
        # Processor time, because load on the machine hardly affects it.
        began = time.process_time()
        result = search.run(evaluator).result
        spent = time.process_time() - began
        fitness[name] = _fitness(result)
        if name == _DEFAULT:
            route_from = (result.hardware or {}).get("route_from")
            seconds = spent
    if has_peers:
        evaluator = Evaluator(problem, threads=1)
        fitness[_PEER] = max(
            (peer(evaluator, name, seconds) for name in PEERS), key=lambda value: value or 0.0
        )
    return Outcome(fitness, route_from, seconds)


def _fitness(result: Result) -> float | None:
    return result.evaluation.fitness if result.evaluation.feasible else None


def peer(
    evaluator: Evaluator,
    name: str,
    seconds: float,
    *,
    clock: Callable[[], float] = time.process_time,
) -> float | None:
    """Return the best F that a planner of OMPL finds in some seconds; None without a path."""
    best: float | None = None
    began, seed = clock(), 0
    while (left := seconds - (clock() - began)) > 0:
        path = solve(evaluator, name, seed, left)
        seed += 1
        if path is None:
            break
        for each in (path, *polished(evaluator.problem, [path])):
            found = evaluator.evaluate(each)
            if found.feasible and found.fitness > (best or 0.0):
                best = found.fitness
    return best


def prepare() -> None:
    """Compile all code, or load it from the cache, before anything is timed."""
    plan(("fractal", TUNING[0], None), False, generations=2)
