"""More than a hundred random problems without a path: the reason given is the true one."""

import dataclasses

import numpy as np
import pytest

from pathgene.host.diagnosis import diagnose
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Options
from pathgene.host.planners.grid.astar import AstarPlanner
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon
from tests.support.host.closed_problems import KINDS, WIDTH_M, ends, hills, star, terrain


# Searches of two margins and four slopes, and of two distances around both ends.
MOST_SEARCHES = 2 * 4 + 2 * 2 * 8


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
@pytest.mark.parametrize(
    "seed", [0, 1, 2, *(pytest.param(seed, marks=pytest.mark.ci) for seed in range(3, 10))]
)
def test_names_the_reason(kind, seed):
    made = kind(np.random.default_rng([seed, KINDS.index(kind)]))
    reason = diagnose(made.problem)
    assert (reason.code, reason.proven) == (made.code, made.proven), reason.sentence
    assert set(reason.zones) <= set(made.zones)
    assert bool(reason.zones) == bool(made.zones)
    if made.limit is not None:
        assert reason.figure is not None
        assert reason.figure.limit == made.limit
    if made.end is not None:
        assert reason.end == made.end
    assert reason.place is not None
    if made.code == "closed" and made.zones:
        left = [
            zone
            for number, zone in enumerate(made.problem.zones, 1)
            if f"zone {zone.name or number}" not in reason.zones
        ]
        opened = dataclasses.replace(made.problem, zones=left)
        assert diagnose(opened).code != "closed", reason.zones


def random_problem(seed):
    """Return a problem with zones, voids and a ceiling; some problems barely have a path."""
    rng = np.random.default_rng([seed, 99])
    heights = hills(rng, 200.0)
    if rng.random() < 0.5:
        heights[: int(rng.integers(20, 78)), 40] = np.nan
    ground = terrain(heights)
    start, goal = ends(rng, ground)
    zones = []
    x, y = rng.uniform(0.35, 0.65) * WIDTH_M, -100.0
    while y < WIDTH_M:
        radius = rng.uniform(80, 300)
        zones.append(Circle(x, y + radius, radius))
        y += 2 * radius + rng.choice([20.0, 40.0, 70.0, 120.0, 250.0])
    center = goal if rng.random() < 0.5 else start
    hole = star(rng, *center[:2], 400)
    side = np.array([*hole[:6], *(np.array(hole[:6][::-1]) * 1.02)])
    zones.append(Polygon(tuple(map(tuple, side.tolist()))))
    top = float(np.nanmax(heights)) + rng.uniform(-60, 150)
    zones = [
        zone
        for zone in zones
        if not any(zone.covers(np.array([p[0]]), np.array([p[1]])).any() for p in (start, goal))
    ]
    rules = Rules(clearance_m=float(rng.choice([0, 30])), ceiling_m=max(top, start[2], goal[2]))
    return Problem(ground, start, goal, zones=zones, rules=rules)


@pytest.mark.parametrize(
    "block", [0, *(pytest.param(block, marks=pytest.mark.ci) for block in range(1, 8))]
)
def test_proves_nothing_that_a_path_disproves(block):
    found = 0
    for seed in range(8 * block, 8 * block + 8):
        problem = random_problem(seed)
        try:
            evaluator = Evaluator(problem)
        except InputError:
            continue  # The straight line is too steep a glide.
        result = AstarPlanner().plan(evaluator, Options(generations=MOST_SEARCHES))
        if result.evaluation.feasible:
            found += 1
            assert not diagnose(problem).proven, seed
    assert found >= 1
