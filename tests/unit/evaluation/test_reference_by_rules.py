"""The search's compiled evaluation compared with the plain definition, under the rules."""

import dataclasses
from collections import Counter

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator, reference
from tests.support.host.flight_cases import random_case


def random_problem(seed):
    """Return a problem without timed zones, which the definition of the search leaves out."""
    problem, path = random_case(np.random.default_rng(seed))
    zones = tuple(zone for zone in problem.zones if zone.t0_s is None and zone.t1_s is None)
    return dataclasses.replace(problem, zones=zones), path


@pytest.mark.ci
def test_search_agrees_with_the_definition():
    counts = Counter()
    for case in range(250):
        problem, path = random_problem((5, case))
        try:
            evaluator = Evaluator(problem, threads=1)
        except InputError:
            continue
        terms = reference.evaluate(problem, path)
        penalty, cost = (
            values[0] for values in evaluator.penalty_cost(path[None], np.array([len(path)]))
        )
        fitness = evaluator.fitness(path[None], np.array([len(path)]))[0]
        assert cost == pytest.approx(terms.cost, rel=1e-9), case
        # Samples at the border of two cells may fall to either side: one part for each piece.
        parts = 2 * len(path) * evaluator.ds_m
        sampled = terms.distance_under_terrain_m + terms.distance_in_nofly_m
        closed = terms.penalty - sampled
        assert penalty >= closed * (1 - 1e-9)
        assert penalty == pytest.approx(terms.penalty, rel=1e-9, abs=parts), case
        counts["exact"] += penalty == pytest.approx(terms.penalty, rel=1e-9)
        counts["feasible"] += fitness > 1
        counts["paths"] += 1
        for name in ("wind", "start_heading_deg", "goal_heading_deg", "zones"):
            counts[name] += getattr(problem, name) not in (None, (), (0.0, 0.0))
        counts["roof"] += problem.roof is not None
        blind = evaluator.fitness_counted(path[None], np.array([len(path)]), np.array([sampled]))[0]
        if terms.penalty > 0:
            assert blind == pytest.approx(terms.fitness, rel=1e-8), case
    assert counts["exact"] >= 0.97 * counts["paths"]
    assert min(counts[name] for name in ("wind", "start_heading_deg", "zones", "roof")) >= 20
    assert counts["feasible"] >= 20


@pytest.mark.ci
def test_limits_of_reference_and_kernels_agree():
    beyond = 0
    for case in range(150):
        problem, path = random_problem((6, case))
        plane = dataclasses.replace(
            problem.aircraft, engine_power_W=150.0, fuel_weight_N=0.01, service_ceiling_m=60.0
        )
        problem = dataclasses.replace(problem, aircraft=plane)
        try:
            evaluator = Evaluator(problem, threads=1)
        except InputError:
            continue
        terms = reference.evaluate(problem, path)
        sampled = terms.distance_under_terrain_m + terms.distance_in_nofly_m
        fitness = evaluator.fitness_counted(path[None], np.array([len(path)]), np.array([sampled]))[
            0
        ]
        assert fitness == pytest.approx(terms.fitness, rel=1e-8), case
        evaluation = evaluator.evaluate(path)
        beyond += evaluation.distance_beyond_limits_m > 0
        assert evaluation.fuel_N == pytest.approx(terms.fuel_N, rel=1e-9)
        assert evaluation.distance_too_steep_m == pytest.approx(terms.distance_too_steep_m)
    assert beyond > 100
