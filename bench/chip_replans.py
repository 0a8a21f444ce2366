"""Replans on the planner on the chip: a zone pops up on the path ahead of the aircraft."""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from statistics import mean

import numpy as np
from numpy.typing import NDArray

from bench.chip_runs import CHIP, judged_run, terrains
from bench.report import Options, Report
from bench.scenarios import SYNTHETIC, missing, problem
from host.device.boards import open_board
from host.errors import InputError
from host.evaluation import Evaluator
from host.planners import base as planners
from host.planners.astar import AstarPlanner
from host.planners.ga_chip import ChipGeneticPlanner, run_options
from host.problem.changes import changed_problem
from host.problem.corner_map import CornerMap
from host.problem.no_fly_shape import no_fly_shape
from host.problem.problem import Problem
from host.problem.rules import Rules
from host.problem.zones import Circle
from sim.model.planner.drawing_cycles import drawing


__all__ = ["FLOWN", "SCENARIOS", "Replan", "Scenario", "run"]

#: Scenarios of a terrain and seed.
SCENARIOS = 23
#: Rules of the rows, and whether the aircraft's heading is kept. As paper there are none; with a
#: heading there are no distances, since the evaluation as paper knows no headings.
_FREE = Rules(clearance_m=0, corridor_m=0, zone_margin_m=0, reserve=0)
FLOWN: dict[str, tuple[Rules | None, bool]] = {
    "as paper": (None, False),
    "by the rules": (Rules(), False),
    "with a heading": (_FREE, True),
}
#: Milliseconds of the runs from new seeds beside them.
_COLD_MS = (2, 5)
_MOST_SEEDS = 2
_PLAN_MS = 10
#: Radius of the zone as a part of the straight line; part of the path that has been flown.
_RADIUS = 0.02, 0.08
_PLACE = 0.05, 0.6
#: Turning radii between the centre of the zone and aircraft or goal, beside its own radius.
_TURNS = 2
_DRAWS = 200
#: A byte has ten bits on the line.
_BYTES_PER_MS = 3_000_000 / 10 / 1000

_BOARD = "model:?genetic=streaming"


@dataclass(frozen=True)
class Scenario:
    """A changed problem.

    Attributes
    ----------
    problem : Problem
        The rest of the flight, with the zone.
    zone : Circle
        The zone that has appeared.
    astar : float
        F of ``astar`` for it, by the host's full evaluation; 0 where ``astar`` finds no path.
    """

    problem: Problem
    zone: Circle
    astar: float


@dataclass(frozen=True)
class Replan:
    """A replan of a scenario.

    Attributes
    ----------
    astar : float
        As in the scenario.
    fitness : tuple of float
        F of the feasible path after the first run and after a retry; 0 where there is none.
    cycles : tuple of int
        The chip's counter at the end of the first run and of all runs.
    drawing : int
        Cycles of BLOCK on the chip.
    line : tuple of int
        Bytes of both directions at the same ends, from BLOCK to BEST.
    cold : tuple of float
        F of a run from new seeds for each of the times.
    """

    astar: float
    fitness: tuple[float, float]
    cycles: tuple[int, int]
    drawing: int
    line: tuple[int, int]
    cold: tuple[float, ...]

    def ms(self, runs: int) -> float:
        """Return the time of BLOCK, runs and line, one after the other, milliseconds."""
        chip = (self.drawing + self.cycles[runs]) / (CHIP.clock_hz / 1000)
        return chip + self.line[runs] / _BYTES_PER_MS


def run(options: Options) -> Report:
    """Measure the rows with ``only`` in their names, all by default."""
    wanted = [name for name in FLOWN if options.only in name]
    if not wanted:
        raise InputError(f"No row has {options.only!r} in its name; there are {', '.join(FLOWN)}.")
    seeds = min(options.seeds, _MOST_SEEDS)
    columns = ("feasible", "share", "mean F against astar")
    report = Report(
        f"Replans on two islands, {SCENARIOS} scenarios on each terrain, {seeds} seeds",
        ("rules", *columns, "cycles, mean", "p99", "ms from BLOCK to BEST, mean", "p99"),
        notes=[
            "Feasible by the strict rule, of the scenarios where astar finds a path. Cycles are",
            "the chip's, from PROBLEM to BEST. From BLOCK to BEST: drawing, runs and the bytes of",
            "all frames at 3 Mbaud, one after the other; the host's own time is not in it.",
            *missing(),
        ],
    )
    cold = Report("The same from new seeds", ("rules", "run", *columns))
    with ProcessPoolExecutor(initializer=_compile) as pool:
        for name in wanted:
            tasks = [(name, terrain, seed) for terrain in terrains() for seed in range(seeds)]
            replans = [each for some in pool.map(_replans, tasks) for each in some]
            for runs, title in enumerate((name, f"{name}, and a retry")):
                cycles = [each.cycles[runs] for each in replans]
                times = [each.ms(runs) for each in replans]
                report.rows.append(
                    (
                        title,
                        *_found([(each.fitness[runs], each.astar) for each in replans]),
                        round(mean(cycles)),
                        round(_p99(cycles)),
                        f"{mean(times):.2f}",
                        f"{_p99(times):.2f}",
                    )
                )
            for number, chip_ms in enumerate(_COLD_MS):
                found = _found([(each.cold[number], each.astar) for each in replans])
                cold.rows.append((name, f"{chip_ms} ms", *found))
            print(f"chip-replans: {name} done", file=sys.stderr, flush=True)
    return dataclasses.replace(report, further=[cold])


def _found(pairs: Sequence[tuple[float, float]]) -> tuple[str, str, str]:
    """Return how many are feasible of those that ``astar`` finds, their share, and the gain."""
    solvable = [(own, other) for own, other in pairs if other]
    gains = [own - other for own, other in solvable if own]
    count = f"{len(gains)} of {len(solvable)}"
    return count, f"{len(gains) / len(solvable):.1%}", f"{mean(gains):+.4f}"


def _p99(values: Sequence[float]) -> float:
    return float(np.percentile(values, 99, method="higher"))


def _compile() -> None:
    _replans(("as paper", SYNTHETIC[0], 0), scenarios=1)


def _replans(task: tuple[str, str, int], scenarios: int = SCENARIOS) -> list[Replan]:
    name, terrain, seed = task
    rules, has_heading = FLOWN[name]
    evaluator = Evaluator(dataclasses.replace(problem(terrain), rules=rules), threads=1)
    with open_board(_BOARD) as chip:
        planner = ChipGeneticPlanner(board=chip, chip_ms=_PLAN_MS, polish="off")
        search = planners.Options(seed=seed, generations=(1 << 32) - 1)
        path = planner.plan(evaluator, search).path
        replans = []
        for scenario in _scenarios(evaluator.problem, path, seed, scenarios, has_heading):
            # The population of a scenario is that of the path that is flown.
            before = planner.plan(evaluator, search)
            assert before.replanner is not None
            replans.append(_replan(before.replanner, scenario, seed))
    return replans


def _scenarios(
    task: Problem, path: NDArray[np.float64], seed: int, count: int, has_heading: bool
) -> Iterator[Scenario]:
    """Yield so many scenarios on a path; draws that leave no problem are drawn anew."""
    rng = np.random.default_rng(seed)
    steps = np.diff(path, axis=0)
    along = np.concatenate(([0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))))
    straight = math.dist(task.start[:2], task.goal[:2])
    made = 0
    for _ in range(_DRAWS * count):
        if made == count:
            return
        place = along[-1] * rng.uniform(*_PLACE)
        radius = straight * rng.uniform(*_RADIUS)
        away = radius + _TURNS * task.limits.turn_radius_m
        if along[-1] - place < 2 * away:
            continue
        start, centre = (
            tuple(float(np.interp(at, along, path[:, axis])) for axis in range(3))
            for at in (place, place + rng.uniform(away, along[-1] - place - away))
        )
        segment = min(int(np.searchsorted(along, place, "right")) - 1, len(steps) - 1)
        east, north = steps[segment, :2]
        heading = math.degrees(math.atan2(east, north)) % 360 if has_heading else None
        if min(math.dist(centre[:2], end[:2]) for end in (start, task.goal)) < away:
            continue
        zone = Circle(centre[0], centre[1], radius)
        try:
            changed = changed_problem(task, [zone], start, heading)
        except InputError:
            continue
        made += 1
        found = AstarPlanner().plan(Evaluator(changed, threads=1), planners.Options(seed=seed))
        feasible = found.evaluation.feasible
        yield Scenario(changed, zone, found.evaluation.fitness if feasible else 0)
    raise InputError(f"Only {made} of {count} scenarios were found on a path.")


def _replan(replanner: planners.Replanner, scenario: Scenario, seed: int) -> Replan:
    evaluator = Evaluator(scenario.problem, threads=1)
    result = replanner.replan(evaluator, planners.Options(seed=seed))
    hardware = result.hardware
    assert hardware is not None
    done = hardware["runs"]
    fitness = result.evaluation.fitness if result.evaluation.feasible else 0.0
    sent = [sum(each["bytes"].values()) for each in done]
    grid = CornerMap(CHIP, scenario.problem)
    shape = no_fly_shape(grid, scenario.zone)
    return Replan(
        scenario.astar,
        (fitness if len(done) == 1 else 0.0, fitness),
        (done[0]["cycles"], sum(each["cycles"] for each in done)),
        0 if shape is None else drawing(shape),
        (sent[0], sum(sent)),
        tuple(_cold(evaluator, grid, seed, chip_ms) for chip_ms in _COLD_MS),
    )


def _cold(evaluator: Evaluator, grid: CornerMap, seed: int, chip_ms: int) -> float:
    most = run_options(CHIP, seed=seed, chip_ms=chip_ms, generations=(1 << 32) - 1)
    outcome = judged_run(evaluator, grid, most)
    return outcome.fitness if outcome.feasible else 0.0
