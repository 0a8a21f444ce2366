"""Evaluations per second on one core, milliseconds of the strict rule, cost of a clearance."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable, Sequence
from functools import partial
from statistics import median
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench.quality import VARIANTS, Variant
from bench.report import Options as BenchOptions
from bench.report import Report
from bench.scenarios import EMBEDDED, SYNTHETIC, problem
from pathgene.host.device.boards import open_board
from pathgene.host.device.chip import Chip
from pathgene.host.device.paths import unpack_waypoints
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import PLANNERS, make
from pathgene.host.planners.allaire.ga_fpga import FpgaGeneticPlanner
from pathgene.host.planners.base import Options, Result
from pathgene.host.problem.chip_map import ChipMap
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon


#: The timed planners, by their names in ``BENCH=quality``.
ENTRANTS = tuple(
    variant
    for variant in VARIANTS
    if variant.name in ("ga-fpga", "ga-pc", "ga-pc from astar", "astar", "fpa-2opt")
)
#: The maps that come with the package.
_MAPS = (EMBEDDED, *SYNTHETIC)
_WITHOUT, _WITH = Rules(clearance_m=0), Rules(clearance_m=30)

# Ends as shares of both axes: 40 km apart on the embedded map.
_ENDS = 0.03, 0.97
_HEIGHT_M = 100.0
# Zones follow each other along the line, on it and on both sides of it; shares of its length.
_ZONES = 20
_FIRST, _LAST = 0.1, 0.9
_BESIDE = -0.09, 0.0, 0.09
_RADIUS = 0.025
_CORNERS = 6


class Timed(NamedTuple):
    """Processor time of a plan, and the number of its evaluations of whole paths."""

    seconds: float
    evaluations: int


def strict_table(repeats: int) -> Report:
    """Time the strict rule on a path of each planner over 40 km among 20 zones."""
    task = long_problem()
    evaluator = Evaluator(task, threads=1)
    report = Report(
        f"Strict evaluation, {len(task.zones)} zones",
        ("path of", "points", "km", "strict rule, ms", "all figures of the summary, ms"),
        notes=[
            f"{task.terrain.name}, corner to corner, with the default rules; half of the zones are",
            f"circles, half polygons of {_CORNERS} corners. Strict rule: penalty and cost of a",
            "path, which decide if it is feasible. All figures: the least clearance, the greatest",
            "height, the worst value of each limit and its place, voids, and the penalty at",
            f"samples, too. Medians of {repeats} calls, processor time.",
        ],
    )
    for variant in ENTRANTS:
        path = _plan(evaluator, variant, seed=0).path
        one, length = path[None], np.array([len(path)])
        report.rows.append(
            (
                variant.name,
                len(path),
                evaluator.evaluate(path).length_m / 1e3,
                _milliseconds(partial(evaluator.penalty_cost, one, length, fine=True), repeats),
                _milliseconds(partial(evaluator.evaluate, path), repeats),
            )
        )
    return report


def clearance_table(rounds: int) -> Report:
    """Time plans without and with a clearance, alternately."""
    report = Report(
        "Planning with a clearance of 30 m, times planning with 0 m",
        ("planner", *_MAPS, "all maps", "CPU seconds with 30 m"),
        notes=[
            "Scenarios of BENCH=quality, all other rules by default, one thread. Each cell is the",
            f"median of {rounds} ratios of processor time. A ratio is of two plans with one seed,",
            "in turn, without the clearance first; the problem's rasters are included.",
            "In brackets: the same of the number of evaluations, where it differs. CPU seconds:",
            "the least and the greatest median of a map.",
        ],
    )
    runs = {}
    for variant in ENTRANTS:
        pairs = {name: _in_turn(name, variant, rounds) for name in _MAPS}
        runs[variant.name] = pairs
        medians = [median(safe.seconds for _, safe in some) for some in pairs.values()]
        report.rows.append(
            (
                variant.name,
                *(_ratios(pairs[name]) for name in _MAPS),
                _ratios([pair for some in pairs.values() for pair in some]),
                f"{min(medians):.2f} to {max(medians):.2f}",
            )
        )
    report.data = {"runs": runs}
    return report


def long_problem() -> Problem:
    """Return a problem of 40 km with 20 zones on and near the straight line."""
    terrain = problem(EMBEDDED).terrain
    start, goal = (
        (share * terrain.width_m, share * terrain.height_m, _HEIGHT_M) for share in _ENDS
    )
    east, north = goal[0] - start[0], goal[1] - start[1]
    radius_m = _RADIUS * math.hypot(east, north)
    zones: list[Circle | Polygon] = []
    for number in range(_ZONES):
        along = _FIRST + (_LAST - _FIRST) * number / (_ZONES - 1)
        beside = _BESIDE[number % len(_BESIDE)]
        x = start[0] + along * east - beside * north
        y = start[1] + along * north + beside * east
        zones.append(_hexagon(x, y, radius_m) if number % 2 else Circle(x, y, radius_m))
    return Problem(terrain, start, goal, zones=zones, agl=True)


def _hexagon(x: float, y: float, radius_m: float) -> Polygon:
    angles = [2 * math.pi * corner / _CORNERS for corner in range(_CORNERS)]
    return Polygon(
        tuple((x + radius_m * math.cos(at), y + radius_m * math.sin(at)) for at in angles)
    )


def _in_turn(name: str, variant: Variant, rounds: int) -> list[tuple[Timed, Timed]]:
    """Time plans without and with a clearance, in pairs with the same seed."""
    scenario = problem(name)
    # Compiles or loads the code before anything is timed.
    for rules in (_WITHOUT, _WITH):
        _timed(scenario, rules, variant, seed=0)
    return [
        (_timed(scenario, _WITHOUT, variant, seed), _timed(scenario, _WITH, variant, seed))
        for seed in range(rounds)
    ]


def _timed(scenario: Problem, rules: Rules, variant: Variant, seed: int) -> Timed:
    """Plan, including the rasters of the problem."""
    task = dataclasses.replace(scenario, rules=rules)
    # Processor time instead of wall time, because load on the machine hardly affects it.
    started = time.process_time()
    result = _plan(Evaluator(task, threads=1), variant, seed)
    return Timed(time.process_time() - started, result.evaluations)


def _ratios(pairs: Sequence[tuple[Timed, Timed]]) -> str:
    """Return the table cell for pairs without and with a clearance."""
    seconds = median(safe.seconds / free.seconds for free, safe in pairs)
    evaluations = f"{median(safe.evaluations / free.evaluations for free, safe in pairs):.2f}"
    return f"{seconds:.2f}" + (f" ({evaluations})" if evaluations != "1.00" else "")


def _plan(evaluator: Evaluator, variant: Variant, seed: int) -> Result:
    planner = make(variant.planner, **variant.options)
    generations = PLANNERS[variant.planner].generations
    return planner.plan(evaluator, Options(seed=seed, generations=generations))


def _milliseconds(call: Callable[[], object], repeats: int) -> float:
    """Return the median processor time of a call, after one untimed call."""
    call()
    passed = []
    for _ in range(repeats):
        started = time.process_time_ns()
        call()
        passed.append(time.process_time_ns() - started)
    return median(passed) / 1e6


_RANDOM_PATHS, _RANDOM_WAYPOINTS = 32, 8
# Maximum number of plans without and with a clearance, and of calls of the strict rule, per
# planner.
_MOST_ROUNDS, _REPEATS = 9, 200


def run(options: BenchOptions) -> Report:
    """Measure on one thread: populations in paper mode, single paths by the strict rule, plans."""
    report = _populations(options.seeds)
    clearance = clearance_table(min(options.seeds, _MOST_ROUNDS))
    report.further = [strict_table(_REPEATS), clearance]
    report.data = clearance.data
    return report


def _populations(seeds: int) -> Report:
    """Evaluate final populations of many seeds and random paths, each once."""
    scenario = problem(EMBEDDED)
    evaluator = Evaluator(scenario, threads=1)
    paths = [path for seed in range(seeds) for path in _final_population(evaluator, seed)]
    rng = np.random.default_rng(0)
    terrain = scenario.terrain
    for _ in range(_RANDOM_PATHS):
        inner = rng.random((_RANDOM_WAYPOINTS, 3))
        inner *= terrain.width_m, terrain.height_m, terrain.highest - terrain.lowest
        inner[:, 2] += terrain.lowest
        paths.append(np.concatenate(([scenario.start], inner, [scenario.goal])))
    lengths = np.array([len(path) for path in paths])
    padded: NDArray[np.float64] = np.zeros((len(paths), int(lengths.max()), 3))
    for row, path in zip(padded, paths, strict=True):
        row[: len(path)] = path
    evaluator.fitness(padded[:2], lengths[:2])
    started = time.process_time()
    evaluator.fitness(padded, lengths)
    seconds = time.process_time() - started
    return Report(
        "Evaluation, paper mode",
        ("terrain", "paths", "ds m", "evaluations per second and core"),
        [(terrain.name, len(paths), float(scenario.ds_m), len(paths) / seconds)],
        [
            "Final population of each seed of ga-fpga, and 32 random paths of 8 waypoints, each",
            "once; processor time of one thread, no caching, no early rejection.",
        ],
    )


def _final_population(evaluator: Evaluator, seed: int) -> list[NDArray[np.float64]]:
    chips: list[Chip] = []

    def keep(url: str) -> Chip:
        chips.append(open_board(url))
        return chips[-1]

    scenario = evaluator.problem
    FpgaGeneticPlanner(open_board=keep).plan(evaluator, Options(seed=seed))
    (chip,) = chips
    grid = ChipMap(chip.config, scenario)
    return [
        np.concatenate(
            ([scenario.start], grid.to_metres(unpack_waypoints(chip.config, path)), [scenario.goal])
        )
        for path in chip.paths
    ]
