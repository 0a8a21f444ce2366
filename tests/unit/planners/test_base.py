"""Stop criteria, the record of a run and the final choice."""

import dataclasses
import math
import time

import numpy as np
import pytest
from numba.core import event

from pathgene.host.errors import InputError
from pathgene.host.planners import base
from pathgene.host.planners.base import Options, Run, Stop
from pathgene.host.planners.choice import choose
from pathgene.host.planners.roulette import roulette
from pathgene.jit import COMPILING


def paths_of(evaluator, *inner):
    problem = evaluator.problem
    return [np.array([problem.start, *points, problem.goal]) for points in inner]


def infeasible(count):
    """Return paths through the wall, each with a different first waypoint."""
    return [[(1500 + 7 * i, 600, 200), (4000, 650, 210)] for i in range(count)]


FREE = [(3050, 3600, 520), (4800, 3300, 450)]  # Through the gap, around the zone.


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"generations": 0}, "The number of generations must be 1 or more, not 0."),
        ({"time_limit_s": 0.0}, "The time limit must be a positive number of seconds, not 0."),
        (
            {"time_limit_s": math.nan},
            "The time limit must be a positive number of seconds, not nan.",
        ),
        (
            {"time_limit_s": math.inf},
            "The time limit must be a positive number of seconds, not inf.",
        ),
        ({"target_fitness": math.nan}, "The target fitness must be a finite number, not nan."),
        ({"seed": -1}, "The seed must be from 0 to 2**64 - 1, not -1."),
        ({"generations": 1.5}, "The number of generations must be an integer, not 1.5."),
        ({"generations": None}, "The number of generations must be an integer, not None."),
        ({"time_limit_s": "x"}, "The time limit must be a number, not 'x'."),
        ({"target_fitness": "x"}, "The target fitness must be a number, not 'x'."),
        ({"population": 8.5}, "The population must be an integer, not 8.5."),
        ({"seed": 1.5}, "The seed must be an integer, not 1.5."),
        ({"seed": "x"}, "The seed must be an integer, not 'x'."),
        ({"seed": 1 << 64}, f"The seed must be from 0 to 2**64 - 1, not {1 << 64}."),
    ],
)
def test_options_check_themselves(change, sentence):
    with pytest.raises(InputError) as caught:
        Options(**change)
    assert str(caught.value) == sentence


def test_options_keep_plain_numbers():
    """The seed must fit into a frame, and every option into JSON."""
    options = Options(generations=np.int64(5), time_limit_s=np.float32(2), seed=np.uint64(3))
    assert [type(value) for value in dataclasses.astuple(options)] == [
        int,
        float,
        type(None),
        type(None),
        int,
    ]
    assert options == Options(generations=5, time_limit_s=2.0, seed=3)


def test_an_observer_sees_each_better_path_once_before_its_generation(evaluator):
    class Observer:
        def __init__(self):
            self.seen = []

        def __call__(self, generation, best, mean):
            self.seen.append((generation, best))

        def improved(self, path):
            self.seen.append(path.tolist())

    observer = Observer()
    run = Run(evaluator, Options(), progress=observer)
    worse, better = paths_of(evaluator, infeasible(1)[0], FREE)
    low = run.fitness([worse])
    run.record(0, low)
    run.record(1, low)
    high = run.fitness([worse, better])
    run.record(2, high)
    assert observer.seen == [
        worse.tolist(),
        (0, low[0]),
        (1, low[0]),
        better.tolist(),
        (2, high[1]),
    ]
    assert np.array_equal(run.result().path, better)


def test_continues_until_a_criterion_is_met(evaluator):
    run = Run(evaluator, Options(generations=2, target_fitness=1.9))
    fitness = run.fitness(paths_of(evaluator, FREE))
    for generation in range(3):
        assert run.stopped_by() is None
        run.record(generation, fitness)
    assert run.stopped_by() == "generations"


def test_first_criterion_met_stops(evaluator):
    stop = Stop()
    run = Run(evaluator, Options(generations=1, target_fitness=1.0), stop=stop)
    run.record(1, run.fitness(paths_of(evaluator, FREE)))
    assert run.stopped_by() == "target-fitness"
    run.failure = "The board is lost."
    assert run.stopped_by() == "failure"
    stop.request()
    assert run.stopped_by() == "interrupt"


def test_time_limit(evaluator):
    run = Run(evaluator, Options(time_limit_s=0.02))
    assert run.stopped_by() is None
    time.sleep(0.03)
    assert run.stopped_by() == "time-limit"


def test_record_keeps_best_so_far_and_mean(evaluator, record):
    run = Run(evaluator, Options(), progress=record)
    good = run.fitness(paths_of(evaluator, FREE, *infeasible(1)))
    run.record(0, good)
    bad = run.fitness(paths_of(evaluator, *infeasible(2)))
    run.record(1, bad)
    assert good[0] > 1 > good[1]
    assert run.history == record.seen == [[0, good[0], good.mean()], [1, good[0], bad.mean()]]
    assert run.history_evaluations == run.result().history_evaluations == [2, 4]
    assert run.evaluations == 4


def test_keeps_candidates_evaluated_elsewhere(evaluator, record):
    run = Run(evaluator, Options(), progress=record)
    paths = paths_of(evaluator, FREE, *infeasible(2))
    values = evaluator.fitness(np.stack(paths), np.full(3, 4))
    run.keep(paths, values)
    run.note(7, 0.25)
    run.cut_short = 5
    assert run.history == record.seen == [[7, values[0], 0.25]]
    result = run.result()
    assert [value for value, _ in result.archive] == [values[0]]
    assert np.array_equal(result.path, paths[0])
    assert (result.evaluations, result.cut_short) == (0, 5)


def test_population_of_mixed_lengths_equals_single_evaluations(evaluator):
    paths = paths_of(evaluator, FREE, FREE[:1], [], [*FREE, (5000, 1500, 300)])
    fitness = Run(evaluator, Options()).fitness(paths)
    assert fitness.tolist() == [
        pytest.approx(evaluator.evaluate(path).fitness, rel=1e-12) for path in paths
    ]


def test_archive_has_distinct_candidates_best_first(evaluator):
    run = Run(evaluator, Options())
    better = [(3050, 3500, 460), (4800, 3000, 380)]
    values = run.fitness(paths_of(evaluator, *infeasible(3), FREE, better, FREE))
    run.record(0, values)
    archive = run.result().archive
    assert [value for value, _ in archive] == sorted(values[3:5].tolist(), reverse=True)


def test_archive_without_feasible_candidates_is_the_best(evaluator):
    run = Run(evaluator, Options())
    values = run.fitness(paths_of(evaluator, *infeasible(5)))
    run.record(0, values)
    result = run.result()
    assert [value for value, _ in result.archive] == [values.max()]
    assert not result.evaluation.feasible
    assert result.evaluation.fitness == pytest.approx(values.max())


def test_full_archive_keeps_the_best(evaluator, monkeypatch):
    monkeypatch.setattr(base, "_ARCHIVE_SIZE", 4)
    run = Run(evaluator, Options())
    many = [[(3050, 3600, 520 + i % 17), (4800, 3300, 450)] for i in range(17)]
    values = np.concatenate([run.fitness(paths_of(evaluator, points)) for points in many])
    run.record(0, values)
    archive = [value for value, _ in run.result().archive]
    assert archive[:4] == sorted(values.tolist(), reverse=True)[:4]
    assert len(archive) < 8


def test_chooses_the_best_that_is_feasible_between_the_samples(make_evaluator):
    # A spike one node wide between two samples 40 m apart, which only fine samples hit.
    evaluator = make_evaluator(np.full((41, 61), 100.0), zones=(), ds_m=900.0)
    problem = evaluator.problem
    ground = problem.terrain.elevation.copy()
    ground[6, 30] = 900.0
    hidden = dataclasses.replace(problem.terrain, elevation=ground)
    evaluator = type(evaluator)(dataclasses.replace(problem, terrain=hidden), threads=1)
    low, high = paths_of(
        evaluator, [(2900, 595, 205), (3300, 600, 212)], [(2900, 1800, 300), (4300, 1600, 300)]
    )
    fitness = evaluator.fitness(np.stack((low, high)), np.array([4, 4]))
    assert (fitness > 1).all()
    assert fitness[0] > fitness[1]
    archive = [(fitness[0], low), (fitness[1], high)]

    path, evaluation = choose(evaluator, archive)
    assert np.array_equal(path, high)
    assert evaluation.feasible

    path, evaluation = choose(evaluator, archive[:1])
    assert np.array_equal(path, low)
    assert (evaluation.feasible, evaluation.feasible_at_ds) == (False, True)


def test_phases_add_up(evaluator):
    run = Run(evaluator, Options())
    for _ in range(2):
        with run.phase("sort"):
            time.sleep(0.01)
    run.record(0, run.fitness(paths_of(evaluator, FREE)))
    seconds = run.result().seconds
    assert 0.02 <= seconds["sort"] < 1
    assert sum(value for name, value in seconds.items() if name != "total") <= seconds["total"]


def test_compiling_belongs_to_no_other_phase(evaluator):
    run = Run(evaluator, Options())
    with run.phase("link"), event.trigger_event(COMPILING):
        time.sleep(0.1)
    run.record(0, run.fitness(paths_of(evaluator, FREE)))
    seconds = run.result().seconds
    assert seconds["link"] < 0.05
    assert 0.1 <= seconds["compiling"] < seconds["total"]


def test_roulette_follows_fitness():
    fitness = np.array([1.0, 3.0, 0.5, 1.5])
    draws = roulette(fitness, 60_000, np.random.default_rng(1))
    share = np.bincount(draws, minlength=4) / 60_000
    assert np.abs(share - fitness / fitness.sum()).max() < 0.012
