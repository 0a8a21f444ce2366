"""A run: the compiled and the interpreted one are equal, and it keeps its promises.

``tests/cosim/test_planner_core.py`` compares runs with the gateware.
"""

import dataclasses
import itertools

import numpy as np
import pytest

from pathgene.hdl.protocol.planner import PathClass
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.sim.model.planner.run import plan
from tests.support.planner.cases import SMALL, USUAL, ground, record
from tests.support.planner.plain import interpreted_plan


def problem(config, seed):
    rng = np.random.default_rng(seed)
    return ground(config, rng, blocked=0.001), record(config, rng)


@pytest.mark.ci
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.ci) for seed in (1, 2, 3))]
)
@pytest.mark.parametrize(
    "options",
    [
        RunOptions(cycles=60_000, lifts=0, seeds=16, paths=3),
        RunOptions(cycles=10**9, generations=60, seeds=10, memo=16, share=4),
        RunOptions(cycles=10**9, generations=30, seeds=9, memo=0, give_up_rank=0, lifts=1),
        RunOptions(cycles=0, seeds=8, slopes=(3,)),
        RunOptions(cycles=90_000, generations=5, until_feasible=True, lifts=0, seeds=8),
    ],
    ids=["cycles", "generations", "without-memo", "seeds-alone", "until-feasible"],
)
def test_compiled_run_is_the_interpreted_one_on_a_small_chip(options, seed):
    options = dataclasses.replace(options, seed=seed, give_up_rank=min(options.give_up_rank, 7))
    heights, problem_record = problem(SMALL, seed)
    outcome = plan(SMALL, heights, problem_record, options, marked=40)
    assert outcome == interpreted_plan(SMALL, heights, problem_record, options, marked=40)
    assert outcome.keys == sorted(set(outcome.keys))


@pytest.mark.ci
def test_compiled_run_is_the_interpreted_one_on_the_usual_chip():
    options = RunOptions(seed=5, cycles=10**9, generations=12, seeds=32)
    heights, problem_record = problem(USUAL, 5)
    assert plan(USUAL, heights, problem_record, options) == interpreted_plan(
        USUAL, heights, problem_record, options
    )


@pytest.mark.ci
def test_a_memo_of_any_size_changes_nothing_but_cycles():
    heights, problem_record = problem(USUAL, 6)
    outcomes = [
        plan(
            USUAL,
            heights,
            problem_record,
            RunOptions(seed=1, cycles=10**9, generations=200, memo=memo),
        )
        for memo in (0, 8, 512)
    ]
    assert len({outcome.cycles for outcome in outcomes}) == 3
    assert len({(str(outcome.paths), str(outcome.keys)) for outcome in outcomes}) == 1


def test_longer_runs_find_better_paths():
    heights, problem_record = problem(USUAL, 7)
    runs = [
        plan(USUAL, heights, problem_record, RunOptions(seed=2, cycles=cycles))
        for cycles in (0, 200_000, 1_000_000)
    ]
    assert [run.keys[0] for run in runs] == sorted((run.keys[0] for run in runs), reverse=True)
    assert runs[-1].classes[0] is PathClass.FEASIBLE
    assert runs[-1].keys[0] < 0.98 * runs[0].keys[0]
    # It ends within a generation of its time limit.
    assert 1_000_000 <= runs[-1].cycles < 1_003_000


def test_a_run_may_wait_for_a_feasible_path():
    """It ends with the generation that has one, or with its cycles if none has."""
    kinds = set()
    for seed, generations, cycles in itertools.product(range(10), (2, 90), (20_000, 200_000)):
        heights, problem_record = problem(SMALL, seed)
        usual = RunOptions(
            seed=seed, cycles=cycles, generations=generations, slopes=(0,), lifts=0, seeds=8
        )
        early = plan(SMALL, heights, problem_record, usual)
        waiting = dataclasses.replace(usual, until_feasible=True)
        late = plan(SMALL, heights, problem_record, waiting)
        if early.classes[0] is PathClass.FEASIBLE:
            # It may be from the last generation, which is collected once nothing more is bred.
            assert late.generations - early.generations in (0, 1)
            kinds.add("at once")
            continue
        if late.classes[0] is PathClass.INFEASIBLE:
            assert late.cycles >= usual.cycles
            kinds.add("never")
            continue
        # One more generation is in flight when a generation is found to have a feasible path.
        assert late.classes[0] is PathClass.FEASIBLE
        assert late.generations > generations
        before = dataclasses.replace(usual, generations=late.generations - 2)
        assert plan(SMALL, heights, problem_record, before).classes[0] is PathClass.INFEASIBLE
        kinds.add("later")
    assert kinds == {"at once", "later", "never"}


def test_seeds_give_different_runs():
    heights, problem_record = problem(USUAL, 8)
    keys = {
        plan(USUAL, heights, problem_record, RunOptions(seed=seed, cycles=200_000)).keys[0]
        for seed in (0, 1, 2**64 - 1)
    }
    assert len(keys) == 3
