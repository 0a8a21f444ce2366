"""Complete runs compared with the reference, on every CPU engine, and their limits."""

import itertools
import time

import numpy as np
import pytest

from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import ENGINES, make
from pathgene.host.planners.airspace import Airspace
from pathgene.host.planners.base import Options, Stop
from pathgene.host.planners.fpa import engines
from pathgene.host.planners.fpa.engines import CpuEngine, Setup
from pathgene.host.planners.fpa.planner import first_population, with_more_waypoints
from pathgene.host.planners.fpa.steps import Pollination
from pathgene.host.planners.fpa.two_opt import is_two_opt
from pathgene.host.planning import Search
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Zone

from . import reference


SMALL = {"population": 24, "seed": 3}


@pytest.mark.parametrize("every", [0, 3])
def test_iterations_match_the_reference(evaluator, every):
    iterations, seed = 9, 2**63 + 5
    space = Airspace(evaluator.problem)
    paths = first_population(space, np.random.default_rng(6), 8, 4)

    def worth(path):
        return evaluator.fitness(path[None], np.array([len(path)]))[0]

    fitness = np.array([worth(path) for path in paths])
    parameters = Pollination(np.uint64(seed), iterations, 0.5, 0.25, 0.02)
    box = np.stack((space.low, space.high))
    engine = CpuEngine(Setup(evaluator, parameters, box, paths, fitness), every, threads=2)
    improved = 0
    for iteration in range(1, iterations + 1):
        ((leader,),) = engine.advance(iteration, 1)
        before = fitness
        paths, fitness = reference.iterate(
            seed,
            iteration,
            iterations,
            is_two_opt(iteration, every),
            paths,
            fitness,
            space.low,
            space.high,
            worth,
        )
        improved += int((fitness > before).sum())
        (found,), (values,) = engine.populations()
        assert found == pytest.approx(paths, rel=1e-12)
        assert values == pytest.approx(fitness, rel=1e-9)
        assert leader.fitness == values.max()
        assert leader.mean == pytest.approx(fitness.mean(), rel=1e-9)
        assert np.array_equal(leader.path, found[np.argmax(values)])
    engine.close()
    assert improved > 10
    assert leader.evaluated + leader.cut_short >= iterations * len(paths)


def test_2_opt_runs_at_its_interval():
    assert [i for i in range(1, 70) if is_two_opt(i, 20)] == [20, 40, 60]
    assert not any(is_two_opt(i, 0) for i in range(70))


def test_result_depends_only_on_the_seed(evaluator):
    options = Options(generations=45, **SMALL)
    results = [
        make("fpa-2opt", engine=engine).plan(Evaluator(evaluator.problem, threads=threads), options)
        for engine, threads in (("sequential", 1), ("threads", 1), ("threads", 2), ("threads", 5))
    ]
    first = results[0]
    for other in results[1:]:
        assert np.array_equal(first.path, other.path)
        assert first.history == other.history
        assert (first.evaluations, first.cut_short) == (other.evaluations, other.cut_short)
    other = make("fpa-2opt").plan(evaluator, Options(generations=45, population=24, seed=4))
    assert not np.array_equal(first.path, other.path)


def test_a_run_is_complete(evaluator):
    result = make("fpa-2opt").plan(evaluator, Options(generations=60, population=64))
    assert result.evaluation.feasible
    assert (result.generations, result.stopped_by, result.hardware) == (60, "generations", None)
    best = [best for _, best, _ in result.history]
    mean = [mean for _, _, mean in result.history]
    assert len(best) == 61
    assert best == sorted(best)
    assert mean == sorted(mean)  # No solution is replaced by a worse one.
    assert result.path.shape == (8, 3)
    assert np.array_equal(result.path[[0, -1]], [evaluator.problem.start, evaluator.problem.goal])
    # The first population, then a candidate per solution and iteration, and the candidates of
    # 2-opt.
    assert result.evaluations + result.cut_short > 64 * 61
    assert result.evaluations >= 64
    for fitness, path in result.archive:
        full = evaluator.fitness(path[None], np.array([len(path)]))[0]
        assert full == fitness
        assert (path[:, :2] >= 0).all()
        assert (path <= (6000, 4000, 700)).all()
    assert len(result.archive) > 10


def test_without_2_opt_a_candidate_for_each_solution(evaluator):
    result = make("fpa", waypoints=3).plan(evaluator, Options(generations=50, **SMALL))
    assert result.evaluations + result.cut_short == 24 * 51
    assert result.cut_short > 0
    assert result.path.shape == (5, 3)


def test_early_rejection_changes_only_the_counts(evaluator):
    options = Options(generations=45, **SMALL)
    quick, thorough = (
        make("fpa-2opt", give_up=give_up).plan(evaluator, options) for give_up in (True, False)
    )
    assert quick.history == thorough.history
    assert np.array_equal(quick.path, thorough.path)
    assert thorough.cut_short == 0
    assert thorough.evaluations == quick.evaluations + quick.cut_short
    assert quick.cut_short > quick.evaluations


def test_2_opt_ends_with_better_paths(evaluator):
    means = [
        np.mean(
            [
                make(name)
                .plan(evaluator, Options(generations=40, population=24, seed=seed))
                .evaluation.fitness
                for seed in range(6)
            ]
        )
        for name in ("fpa", "fpa-2opt")
    ]
    assert means[1] > means[0] + 0.01


def test_stop_criteria(evaluator, record):
    target = make("fpa-2opt").plan(evaluator, Options(target_fitness=1.01, **SMALL), record)
    assert target.stopped_by == "target-fitness"
    assert target.history[-1][1] >= 1.01 > target.history[-2][1]
    assert record.seen == target.history
    limit = make("fpa").plan(evaluator, Options(generations=10**9, time_limit_s=0.2, **SMALL))
    assert limit.stopped_by == "time-limit"
    assert limit.generations > 0


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"waypoints": 0}, "The number of waypoints must be from 1 to 100, not 0."),
        ({"waypoints": 101}, "The number of waypoints must be from 1 to 100, not 101."),
        ({"two_opt_every": -1}, "The iterations between 2-opts must be 0 or more, not -1."),
        (
            {"engine": "abacus"},
            f"There is no engine 'abacus'; the engines are {', '.join(ENGINES)}.",
        ),
    ],
)
def test_refuses_bad_options(options, sentence):
    with pytest.raises(InputError) as caught:
        make("fpa-2opt", **options)
    assert str(caught.value) == sentence


@pytest.mark.parametrize("count", [3, 100_001])
def test_refuses_a_bad_population(evaluator, count):
    sentence = rf"^The population of fpa must be from 4 to 100000, not {count}\.$"
    with pytest.raises(InputError, match=sentence):
        make("fpa").plan(evaluator, Options(population=count))


@pytest.fixture
def engine_of(evaluator):
    """Function that makes engines with the same population of 24 paths of 7 points."""
    space = Airspace(evaluator.problem)
    paths = first_population(space, np.random.default_rng(6), 24, 5)
    fitness = evaluator.fitness(paths, np.full(24, paths.shape[1]))
    engines = []

    def make_engine(threads):
        engines.append(
            CpuEngine(
                Setup(
                    evaluator,
                    Pollination(np.uint64(1), 400, 0.5, 0.25, 0.02),
                    np.stack((space.low, space.high)),
                    paths,
                    fitness,
                ),
                3,
                threads=threads,
            )
        )
        return engines[-1]

    yield make_engine
    for engine in engines:
        engine.close()


@pytest.mark.parametrize("threads", [1, 3])
def test_a_stop_keeps_complete_iterations(engine_of, threads, monkeypatch):
    monkeypatch.setattr(engines, "_LOOK_S", 0.001)
    looks = iter([False, False, False])
    stopped, whole = engine_of(threads), engine_of(1)
    (found,) = stopped.advance(1, 400_000, lambda: next(looks, True))
    assert 0 < len(found) < 400_000
    (expected,) = whole.advance(1, len(found))
    for leader, other in zip(found, expected, strict=True):
        assert np.array_equal(leader.path, other.path)
        assert leader[1:] == other[1:]
    for told, other in zip(stopped.populations(), whole.populations(), strict=True):
        assert np.array_equal(told, other)


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
@pytest.mark.parametrize("where", ["submit", "wait", "share"])
def test_a_failed_thread_blocks_no_other(engine_of, monkeypatch, where, error):
    engine = engine_of(3)
    submit, share = engine._pool.submit, engine._share

    def submit_two(work, thread, *rest):
        if thread == 2:
            raise error
        return submit(work, thread, *rest)

    def fail_one(thread, *rest):
        if thread == 1:
            raise error
        share(thread, *rest)

    def fail(*_):
        raise error

    if where == "submit":
        monkeypatch.setattr(engine._pool, "submit", submit_two)
    elif where == "wait":
        monkeypatch.setattr(engines, "wait", fail)
    else:
        monkeypatch.setattr(engine, "_share", fail_one)
    with pytest.raises(error):
        engine.advance(1, 400_000)


def test_waiting_threads_yield_the_core(engine_of, monkeypatch):
    engine = engine_of(2)
    share = engine._share

    def late(thread, *rest):
        time.sleep(1.0 if thread else 0.0)
        share(thread, *rest)

    monkeypatch.setattr(engine, "_share", late)
    before = time.process_time()
    engine.advance(1, 2)
    assert time.process_time() - before < 0.5


def test_a_time_limit_ends_a_search_within_an_iteration(evaluator):
    # One 2-opt of all these solutions would take minutes.
    options = Options(generations=500, population=3000, time_limit_s=0.5)
    result = make("fpa-2opt", waypoints=60, two_opt_every=1).plan(evaluator, options)
    assert (result.stopped_by, result.generations) == ("time-limit", 0)
    assert len(result.history) == 1


def test_a_target_ends_a_search_in_its_iteration(evaluator):
    whole = make("fpa-2opt").plan(evaluator, Options(generations=60, **SMALL))
    bests = [best for _, best, _ in whole.history]
    target = bests[33]
    result = make("fpa-2opt").plan(
        evaluator, Options(generations=60, target_fitness=target, **SMALL)
    )
    assert result.generations == next(i for i, best in enumerate(bests) if best >= target)
    assert result.history == whole.history[: result.generations + 1]


class Several:
    """An engine for several runs, like a GPU's, made of one CPU engine for each; it may fail."""

    def __init__(self, setups, every, *, fails_at=None):
        self.engines = [CpuEngine(setup, every, threads=1) for setup in setups]
        self.fails_at = fails_at

    def advance(self, first, count, should_stop=engines.never):
        if self.fails_at is not None and first >= self.fails_at:
            raise JobError("The GPU failed (lost).")
        return [engine.advance(first, count, should_stop)[0] for engine in self.engines]

    def populations(self):
        paths, fitness = zip(*(engine.populations() for engine in self.engines), strict=True)
        return np.concatenate(paths), np.concatenate(fitness)

    def close(self):
        for engine in self.engines:
            engine.close()


@pytest.fixture
def several(monkeypatch):
    """Function that makes a planner whose GPU is :class:`Several`."""
    monkeypatch.setattr("pathgene.host.planners.fpa.planner._check_gpu", lambda: None)

    def make_planner(fails_at=None):
        planner = make("fpa-2opt", engine="gpu", two_opt_every=7)
        monkeypatch.setattr(
            planner, "_engine", lambda setups: Several(setups, 7, fails_at=fails_at)
        )
        return planner

    return make_planner


@pytest.mark.parametrize("target", [None, 1.2])
def test_runs_together_are_those_alone(make_evaluator, several, target):
    evaluators = [make_evaluator(), make_evaluator(zones=())] * 2
    options = [
        Options(generations=130, population=24, seed=seed, target_fitness=target)
        for seed in (3, 4, 5, 6)
    ]
    found = several().plan_together(evaluators, options)
    for result, evaluator, each in zip(found, evaluators, options, strict=True):
        alone = make("fpa-2opt", engine="sequential", two_opt_every=7).plan(evaluator, each)
        for name in ("history", "generations", "evaluations", "cut_short", "stopped_by"):
            assert getattr(result, name) == getattr(alone, name)
        assert (result.path == alone.path).all()
    if target is not None:  # Each ends by itself.
        assert len({result.generations for result in found}) > 1


def test_a_run_that_has_ended_is_not_interrupted(make_evaluator, several):
    evaluators = [make_evaluator(zones=()), make_evaluator()]
    options = [Options(generations=130, population=24, seed=5, target_fitness=1.285)] * 2
    # The first run reaches the target earlier.
    first = make("fpa-2opt", engine="sequential", two_opt_every=7).plan(evaluators[0], options[0])
    looks = itertools.count()
    stop = Stop(lambda: next(looks) > 4 * (first.generations + 2))
    found = several().plan_together(evaluators, options, stop)
    assert [result.stopped_by for result in found] == ["target-fitness", "interrupt"]
    assert found[0].generations == first.generations < found[1].generations < 130


def test_a_gpu_that_is_lost_leaves_the_best_paths(evaluator, several):
    options = [Options(generations=200, population=24, seed=seed) for seed in (3, 4)]
    for result in several(fails_at=51).plan_together([evaluator] * 2, options):
        assert (result.generations, result.stopped_by) == (50, "failure")
        assert result.failure == "The GPU failed (lost)."
        assert result.evaluation.fitness == result.history[-1][1] > result.history[0][1]
    with pytest.raises(ValueError, match="more than their seeds"):
        several().plan_together([evaluator] * 2, [options[0], Options(generations=7)])
    with pytest.raises(ValueError, match="one run at a time"):
        make("fpa").plan_together([evaluator], options[:1])


def test_draws_free_paths_with_the_given_ends(evaluator):
    space = Airspace(evaluator.problem)
    paths = first_population(space, np.random.default_rng(1), 40, 6)
    assert paths.shape == (40, 8, 3)
    assert (paths[:, 0] == evaluator.problem.start).all()
    assert (paths[:, -1] == evaluator.problem.goal).all()
    assert space.is_free(paths[:, 1:-1].reshape(-1, 3)).all()
    again = first_population(space, np.random.default_rng(1), 40, 6)
    assert np.array_equal(paths, again)


@pytest.mark.parametrize("waypoints", [2, 6])
def test_given_paths_come_first_with_the_same_course(evaluator, waypoints):
    problem = evaluator.problem
    straight = np.array([problem.start, problem.goal])
    bent = np.array(
        [problem.start, (1000, 3000, 300), (2000, 3500, 400), (4000, 3500, 400), problem.goal]
    )
    paths = first_population(
        Airspace(problem), np.random.default_rng(1), 3, waypoints, [straight, bent]
    )
    assert paths.shape == (3, max(waypoints, 3) + 2, 3)
    for path, given in zip(paths, (straight, bent), strict=False):
        # It has every given point in order, and all further points lie on its legs.
        where = [int(np.flatnonzero((path == point).all(axis=1))[0]) for point in given]
        assert where == sorted(where)
        length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
        assert length == pytest.approx(np.linalg.norm(np.diff(given, axis=0), axis=1).sum())


def test_takes_the_best_of_too_many_given_paths(evaluator):
    straight = np.array([evaluator.problem.start, evaluator.problem.goal])
    paths = first_population(
        Airspace(evaluator.problem), np.random.default_rng(1), 2, 1, [straight] * 5
    )
    assert paths.shape == (2, 3, 3)
    assert np.array_equal(paths[0], paths[1])


def test_new_waypoints_halve_the_longest_leg():
    path = np.array([(0, 0, 0), (100, 0, 0), (400, 0, 30)], dtype=float)
    assert with_more_waypoints(path, 5).tolist() == [
        [0, 0, 0],
        [100, 0, 0],
        [175, 0, 7.5],
        [250, 0, 15],
        [400, 0, 30],
    ]
    assert with_more_waypoints(path, 3) is path


def test_runs_together_honour_the_times_of_zones(make_evaluator, several, monkeypatch):
    block = [(2000, 1500), (4000, 1500), (4000, 4200), (2000, 4200)]
    idle = Zone.polygon(block, t0_s=5000.0)
    busy = Zone.polygon(block, t0_s=1.0)
    cases = [(idle,), (), (busy,)]
    evaluators = [make_evaluator(zones=zones, rules=Rules()) for zones in cases]
    settings = {"generations": 60, "population": 24, "two_opt_every": 7}
    search = Search("fpa-2opt", engine="gpu", **settings)
    monkeypatch.setattr(search, "_planner", several())
    plans = search.run_together(evaluators, [3, 3, 3])
    later, free, around = (plan.result.evaluation.fitness for plan in plans)
    # A zone that is active only after the flight changes nothing, and an active one does.
    assert later == free
    assert around < free
    for plan, evaluator in zip(plans, evaluators, strict=True):
        alone = Search("fpa-2opt", engine="sequential", seed=3, **settings).run(evaluator)
        assert np.array_equal(plan.path, alone.path)
