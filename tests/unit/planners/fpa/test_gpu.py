"""The GPU engine on a GPU: its numbers, many runs at once, and its users."""

import json

import numpy as np
import pytest
from scipy.stats import ttest_ind

from bench.scenarios import TABLE_4, TILES, names_of, problem_at_one_cell
from pathgene import plan, plan_together
from pathgene.host.cli import main
from pathgene.host.errors import InputError, JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.planners import make
from pathgene.host.planners.airspace import Airspace
from pathgene.host.planners.base import Options, Stop
from pathgene.host.planners.fpa.engines import CpuEngine, Setup
from pathgene.host.planners.fpa.planner import first_population
from pathgene.host.planners.fpa.steps import Pollination
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle


def has_gpu():
    from numba import cuda

    return cuda.is_available()


pytestmark = pytest.mark.skipif(not has_gpu(), reason="there is no NVIDIA GPU")

#: Maximum relative difference between the fitness on GPU and CPU, without samples on cell borders.
TOLERANCE = 1e-9
#: Maximum share of paths with a sample on such a border.
ON_BORDERS = 0.01


def setup_of(evaluator, seed, *, count=64, waypoints=6, iterations=60):
    space = Airspace(evaluator.problem)
    paths = first_population(space, np.random.default_rng(seed), count, waypoints)
    return Setup(
        evaluator,
        Pollination(np.uint64(seed), iterations, 0.5, 0.25, 0.02),
        np.stack((space.low, space.high)),
        paths,
        evaluator.fitness(paths, np.full(count, waypoints + 2)),
    )


def run_engine(setups, iterations=60, every=20, **options):
    from pathgene.host.planners.fpa.cuda import GpuEngine

    engine = GpuEngine(setups, every, stride=iterations, **options)
    leaders = engine.advance(1, iterations)
    return leaders, *engine.populations()


def judge_alike(evaluator, paths, fitness):
    """Check the fitness of paths (m, n, 3) by the CPU; return the share that differs."""
    expected = evaluator.fitness(paths, np.full(len(paths), paths.shape[1]))
    differs = abs(fitness - expected) > TOLERANCE * expected
    assert differs.mean() <= ON_BORDERS, (fitness[differs], expected[differs])
    return differs.mean()


def evaluators(make_evaluator):
    """Return evaluators that cover every branch of the evaluation."""
    paper = make_evaluator().problem
    # Over steep ground, in wind, below an upper limit, with headings at both ends, and with a zone
    # that is entered from above.
    safe = make_evaluator(
        rules=Rules(clearance_m=30.0, ceiling_agl_m=300.0),
        wind=(6.0, -3.0),
        start_heading_deg=80.0,
        goal_heading_deg=100.0,
        zones=(Circle(3000, 600, 500), Circle(4000, 3000, 700, lower_m=350.0)),
    ).problem
    return [
        Evaluator(paper, threads=1),
        Evaluator(paper, threads=1, ds_m=7.0),
        Evaluator(safe, threads=1),
    ]


def test_fitness_is_that_of_the_cpu(make_evaluator):
    for evaluator in evaluators(make_evaluator):
        setup = setup_of(evaluator, 3)
        _, (paths,), (fitness,) = run_engine([setup])
        judge_alike(evaluator, paths, fitness)
        assert (fitness > setup.fitness).mean() > 0.9
        assert (paths[:, [0, -1]] == setup.paths[:, [0, -1]]).all()


def test_first_iterations_are_those_of_the_cpu(make_evaluator):
    for evaluator in evaluators(make_evaluator):
        setup = setup_of(evaluator, 5)
        (leaders,), _, _ = run_engine([setup], 3, every=2)
        (expected,) = CpuEngine(setup, 2, threads=1).advance(1, 3)
        for found, leader in zip(leaders, expected, strict=True):
            assert found.fitness == pytest.approx(leader.fitness, rel=TOLERANCE)
            # A sample on a border may change one path of the 64.
            assert found.mean == pytest.approx(leader.mean, rel=1e-3)
            assert found.path == pytest.approx(leader.path, rel=TOLERANCE)
            assert found.evaluated + found.cut_short == leader.evaluated + leader.cut_short


def test_runs_at_once_are_those_alone(make_evaluator):
    some = evaluators(make_evaluator)
    setups = [setup_of(some[at % len(some)], seed) for at, seed in enumerate(range(9))]
    leaders, paths, fitness = run_engine(setups)
    # The numbers of blocks, and of candidates and threads in a block, do not matter.
    for options in ({"blocks": 3}, {"width": 2}):
        _, *same = run_engine(setups, **options)
        assert (same[0] == paths).all()
        assert (same[1] == fitness).all()
    for at, setup in enumerate(setups):
        (own,), (own_paths,), (own_fitness,) = run_engine([setup])
        assert (own_paths == paths[at]).all()
        assert (own_fitness == fitness[at]).all()
        for one, other in zip(own, leaders[at], strict=True):
            assert one[1:] == other[1:]
            assert (one.path == other.path).all()


@pytest.mark.parametrize(("waypoints", "population"), [(1, 4), (2, 2000), (40, 100), (100, 8)])
def test_any_size(evaluator, waypoints, population):
    planner = make("fpa-2opt", engine="gpu", waypoints=waypoints, two_opt_every=2)
    result = planner.plan(evaluator, Options(generations=5, population=population))
    assert result.generations == 5
    assert result.path.shape == (waypoints + 2, 3)
    assert result.history[-1][1] >= result.history[0][1]


def test_giving_up_does_not_change_the_paths(evaluator):
    options = Options(generations=40, population=64)
    whole, given_up = (
        make("fpa-2opt", engine="gpu", give_up=give_up).plan(evaluator, options)
        for give_up in (False, True)
    )
    assert (whole.path == given_up.path).all()
    assert whole.history == given_up.history
    assert whole.cut_short == 0 < given_up.cut_short
    assert whole.evaluations == given_up.evaluations + given_up.cut_short


def test_a_search_ends_when_asked(evaluator):
    planner = make("fpa", engine="gpu")
    reached = planner.plan(evaluator, Options(target_fitness=1e-6))
    assert reached.stopped_by == "target-fitness"
    assert reached.generations <= 1
    late = planner.plan(evaluator, Options(generations=100_000, time_limit_s=0.2))
    assert late.stopped_by == "time-limit"
    asked = planner.plan(evaluator, Options(), stop=Stop(lambda: True))
    assert (asked.stopped_by, asked.generations) == ("interrupt", 0)


def test_too_little_memory_is_said():
    from numba import cuda

    from pathgene.host.planners.fpa.cuda import reported

    with (
        pytest.raises(JobError, match=r"The GPU failed .* plan fewer problems at once"),
        reported(),
    ):
        cuda.device_array(1 << 46)


def test_problems_are_planned_together(make_evaluator):
    problems = [make_evaluator(zones=zones).problem for zones in ((), (Circle(3000, 600, 400),))]
    options = {"generations": 30, "population": 64}
    plans = plan_together([*problems, problems[0]], seeds=[1, 1, 2], **options)
    assert all(each.evaluation.feasible for each in plans)
    for each, problem, seed in zip(plans, [*problems, problems[0]], (1, 1, 2), strict=True):
        alone = plan(problem, "fpa-2opt", engine="gpu", seed=seed, **options)
        assert (each.path == alone.path).all()
        assert each.summary["seed"] == seed
    with pytest.raises(InputError, match="2 problems and 1 seeds"):
        plan_together(problems, seeds=[1])


def test_a_batch_is_planned_together(tmp_path, capsys):
    files = []
    for name, x in (("one", 300), ("two", 500), ("bad", 90_000)):
        files.append(str(tmp_path / f"{name}.toml"))
        (tmp_path / f"{name}.toml").write_text(
            f'[terrain]\nsource = "canyon"\n[mission]\nstart = [{x}, 300, 60]\n'
            "goal = [4700, 4600, 60]\nagl = true\n"
        )
    out = tmp_path / "out"
    options = ["--planner", "fpa-2opt", "--engine", "gpu", "--generations", "60", "--no-picture"]
    assert main(["batch", *files, *options, "--out", str(out)]) != 0
    rows = {row["name"]: row for row in json.loads((out / "batch.json").read_text())["problems"]}
    assert rows["one"]["fitness"] > 0
    assert rows["two"]["fitness"] > 0
    assert rows["bad"]["bad_input"]
    alone = tmp_path / "alone"
    assert main(["plan", files[0], *options, "--out", str(alone)]) == 0
    summary = json.loads((alone / "summary.json").read_text())
    assert summary["fitness"] == rows["one"]["fitness"]
    capsys.readouterr()


@pytest.mark.long
@pytest.mark.parametrize("name", TABLE_4)
def test_twenty_seeds_are_as_good_as_those_of_the_cpu(name):
    if name not in names_of([name]):
        pytest.skip(f"{TILES[name]} is not beside the repository")
    evaluator = Evaluator(problem_at_one_cell(name))
    options = [Options(generations=500, population=512, seed=seed) for seed in range(20)]
    found = make("fpa-2opt", engine="gpu").plan_together([evaluator] * 20, options)
    expected = [make("fpa-2opt").plan(evaluator, each) for each in options]
    assert all(result.evaluation.feasible for result in (*found, *expected))
    paths = np.stack([path for result in found for _, path in result.archive[:200]])
    fitness = np.array([value for result in found for value, _ in result.archive[:200]])
    differing = judge_alike(evaluator, paths, fitness)
    gpu, cpu = ([result.evaluation.fitness for result in each] for each in (found, expected))
    assert ttest_ind(gpu, cpu, equal_var=False).pvalue > 0.001
    # Up to the first sample on a border, the runs are the same.
    same = [
        ours.history[20][1] == pytest.approx(theirs.history[20][1], rel=TOLERANCE)
        for ours, theirs in zip(found, expected, strict=True)
    ]
    assert sum(same) >= 19
    print(f"{name}: mean F {np.mean(gpu):.4f}, of the CPU {np.mean(cpu):.4f}")
    print(
        f"{sum(same)} of 20 alike after 20 iterations; {differing:.2g} of the paths judged unlike"
    )
