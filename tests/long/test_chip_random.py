"""Random problems over real ground: if astar finds a path, the planner core finds one too."""

from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context

import numpy as np
import pytest

from bench.scenarios import SYNTHETIC, names, problem
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import make
from pathgene.host.planners.base import Options
from pathgene.host.planning import Search
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle
from tests.support.host.flight_oracle import examine


PROBLEMS = 1_000
#: Time of a run on the chip, milliseconds.
CHIP_MS = 20

terrain = cache(lambda name: problem(name).terrain)


def random_problem(rng):
    """Return the evaluator of a flight over any terrain; None if it is refused.

    The ends are anywhere, at least a quarter of the diagonal apart, at heights from below the
    clearance to well above it. Up to six zones lie near the line between them.
    """
    ground = terrain(str(rng.choice([*names(), *SYNTHETIC])))
    clearance_m = float(rng.choice([0, 30, 30, 50, 100]))
    size = np.array([ground.width_m, ground.height_m])
    while True:
        start, goal = rng.uniform(0.03, 0.97, size=(2, 2)) * size
        line_m = float(np.hypot(*(goal - start)))
        if line_m > 0.25 * np.hypot(*size):
            break
    zones = []
    for _ in range(int(rng.integers(7))):
        centre = start + (goal - start) * rng.uniform(0.1, 0.9) + rng.normal(size=2) * 0.12 * line_m
        radius_m = float(rng.uniform(0.02, 0.1)) * line_m
        if all(np.hypot(*(centre - end)) > radius_m + 200 for end in (start, goal)):
            zones.append(Circle(*centre.tolist(), radius_m))
    heights = rng.uniform(max(20, 0.6 * clearance_m), max(150, 1.5 * clearance_m), size=2)
    ends = [
        (*end.tolist(), float(ground.ground(*end)) + height)
        for end, height in zip((start, goal), heights.tolist(), strict=True)
    ]
    if not np.isfinite(ends).all():
        return None
    try:
        return Evaluator(
            Problem(ground, *ends, zones=tuple(zones), rules=Rules(clearance_m=clearance_m)),
            threads=1,
        )
    except InputError:
        # An end in a zone, off the map, or over a void.
        return None


@dataclass(frozen=True)
class Outcome:
    """Outcome of a problem: whether the chip has a path, also guided, and whether astar has."""

    case: int
    blocked: bool
    alone: bool
    found: bool
    solvable: bool


def plan_a_case(case):
    """Return the outcome of a random problem, confirmed by the oracle; None if it is refused."""
    evaluator = random_problem(np.random.default_rng((2026, case)))
    if evaluator is None:
        return None
    flight = evaluator.problem
    straight = evaluator.evaluate(np.array([flight.start, flight.goal]))
    plan = Search("ga-chip", chip_ms=CHIP_MS, seed=case, fallback="astar").run(evaluator)
    # Feasible is the verdict of the strict rule on the reported path.
    assert plan.evaluation == evaluator.evaluate(plan.path), case
    assert plan.evaluation.feasible or plan.reason is not None, case
    # An oracle of dense samples, which shares no code with that rule, must agree.
    if plan.evaluation.feasible:
        assert not examine(flight, plan.path).rejected, case
    return Outcome(
        case,
        blocked=straight.distance_under_terrain_m > 0 or straight.distance_in_nofly_m > 0,
        alone=plan.fallback is None and plan.result.hardware["routes"]["chip"] is not None,
        found=plan.evaluation.feasible,
        solvable=make("astar").plan(evaluator, Options(generations=40)).evaluation.feasible,
    )


@pytest.mark.long
def test_wherever_astar_finds_a_path_the_chip_plans_one_too():
    """Takes about fifteen minutes on two cores."""
    outcomes = []
    with get_context("spawn").Pool() as pool:
        for outcome in pool.imap(plan_a_case, range(5 * PROBLEMS)):
            if outcome is not None:
                outcomes.append(outcome)
                print(len(outcomes), outcome, flush=True)
            if len(outcomes) == PROBLEMS:
                break
    assert len(outcomes) == PROBLEMS
    solvable = [outcome for outcome in outcomes if outcome.solvable]
    assert len(solvable) >= 700
    assert sum(outcome.blocked for outcome in solvable) >= 500
    assert all(outcome.found for outcome in solvable)
    assert sum(outcome.alone for outcome in solvable) >= 0.98 * len(solvable)
