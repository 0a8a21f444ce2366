"""The remainder of an earlier path, and warm runs without a compiler."""

import dataclasses

import numpy as np
import pytest

from pathgene.hdl.protocol.planner import POSITION_FRACTION, PathClass
from pathgene.hdl.protocol.runs import WARM_SLOPES, RunOptions
from pathgene.sim.model.planner.run import plan
from pathgene.sim.model.planner.seeds import ahead
from tests.support.planner.cases import SMALL, USUAL, ground, headed, record
from tests.support.planner.plain import interpreted_plan


def problem(config, seed):
    rng = np.random.default_rng(seed)
    return ground(config, rng, blocked=0.001), record(config, rng)


def moved(config, problem_record, path, seed):
    """The problem that starts at the first waypoint of a path, with headings in some cases."""
    x, y, z = path[0]
    start = {"start_x": x << 8, "start_y": y << 8, "start_altitude": z << 4}
    return headed(config, np.random.default_rng(seed), dataclasses.replace(problem_record, **start))


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.ci) for seed in (1, 2, 3))]
)
@pytest.mark.parametrize(
    "options",
    [
        RunOptions(cycles=10**9, generations=30, slopes=(), seeds=8),
        RunOptions(cycles=10**9, generations=40, slopes=WARM_SLOPES, seeds=9, share=13),
        RunOptions(cycles=10**9, generations=30, slopes=(0,), seeds=8, memo=0, lifts=0),
    ],
    ids=["alone", "fresh", "without-memo"],
)
def test_compiled_warm_run_is_the_interpreted_one(options, seed):
    heights, earlier = problem(SMALL, seed)
    options = dataclasses.replace(options, seed=seed)
    cold = dataclasses.replace(options, slopes=WARM_SLOPES)
    before = plan(SMALL, heights, earlier, cold)
    later = moved(SMALL, earlier, before.paths[0], seed)
    heights[10:14, 10:14] = SMALL.blocked_altitude
    warm = dataclasses.replace(options, warm=True)
    outcome = plan(SMALL, heights, later, warm, before.population)
    assert outcome == interpreted_plan(SMALL, heights, later, warm, before.population)
    assert outcome.population != plan(SMALL, heights, later, cold).population


def test_compiled_warm_run_is_the_interpreted_one_on_the_usual_chip():
    heights, earlier = problem(USUAL, 5)
    before = plan(USUAL, heights, earlier, RunOptions(seed=5, cycles=300_000))
    later = moved(USUAL, earlier, before.paths[0], 1)
    options = RunOptions(
        seed=6, cycles=10**9, generations=8, slopes=WARM_SLOPES, warm=True, seeds=32, share=13
    )
    outcome = plan(USUAL, heights, later, options, before.population)
    assert outcome == interpreted_plan(USUAL, heights, later, options, before.population)


def test_a_run_returns_its_population_from_the_best():
    heights, earlier = problem(USUAL, 7)
    outcome = plan(USUAL, heights, earlier, RunOptions(seed=2, cycles=200_000))
    assert len(outcome.population) == USUAL.population
    # The paths returned are the first of each key, in order. The same path may come twice, once
    # feasible and once given up.
    at = -1
    for path in outcome.paths:
        at = outcome.population.index(path, at + 1)
    assert outcome.paths[0] == outcome.population[0]
    assert len(set(outcome.keys)) == len(outcome.paths)


def test_a_warm_run_goes_on_where_the_earlier_one_ended():
    heights, earlier = problem(USUAL, 7)
    before = plan(USUAL, heights, earlier, RunOptions(seed=2, cycles=1_000_000))
    assert before.classes[0] is PathClass.FEASIBLE
    # No generation: the same paths with the same keys.
    options = RunOptions(slopes=(), warm=True, generations=0)
    again = plan(USUAL, heights, earlier, options, before.population)
    assert again.generations == 0
    assert again.keys[0] == before.keys[0]
    assert sorted(again.population) == sorted(before.population)
    later = plan(
        USUAL, heights, earlier, dataclasses.replace(options, generations=400), before.population
    )
    assert later.keys[0] < before.keys[0]
    assert later.cycles < 500_000


def test_first_waypoints_behind_the_start_are_dropped():
    start = {"start_x": 10 << POSITION_FRACTION, "start_y": 10 << POSITION_FRACTION}
    goal = {"goal_x": 30 << POSITION_FRACTION, "goal_y": 20 << POSITION_FRACTION}
    behind, beside, before = (4, 9, 5), (8, 14, 5), (11, 10, 5)
    problem_record = record(USUAL, np.random.default_rng(0), **start, **goal)

    def drop(path):
        return ahead(USUAL, problem_record, path)

    assert drop([behind, beside, before, before]) == [before, before]
    # A waypoint next to the start is dropped; a later waypoint astern stays.
    assert drop([beside, before, behind, before]) == [before, behind, before]
    assert drop([before, behind, before]) == [before, behind, before]
    # Two waypoints are always kept.
    assert drop([behind, beside, behind]) == [beside, behind]
    assert drop([behind, behind]) == [behind, behind]


def test_only_a_warm_run_goes_on_from_a_population_and_that_is_whole():
    paths = [[(1, 2, 3), (4, 5, 6)]] * SMALL.population
    heights, earlier = problem(SMALL, 0)
    for warm, population, count in ((True, paths[1:], 7), (True, None, 0), (False, paths, 8)):
        message = "A warm run must go on from 8 paths, and another run from none, not from " + str(
            count
        )
        with pytest.raises(ValueError, match=f"^{message}$"):
            plan(
                SMALL,
                heights,
                earlier,
                RunOptions(warm=warm, slopes=(3,), seeds=8, give_up_rank=3),
                population,
            )
