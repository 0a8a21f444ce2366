"""The benchmark of other optimizers: objective, budget, and missing packages."""

import importlib.util

import numpy as np
import pytest

from bench import peers
from bench.peers.optimizers import (
    OPTIMIZERS,
    PLANNERS,
    POPULATION,
    BudgetSpentError,
    Objective,
    solve,
)
from bench.report import Options
from bench.scenarios import problem_at_one_cell
from pathgene.host.evaluation import Evaluator


pytestmark = pytest.mark.ci  # Smoke test of a benchmark.


@pytest.fixture(scope="module")
def evaluator():
    return Evaluator(problem_at_one_cell("canyon"), threads=1)


def test_an_objective_is_our_fitness_within_its_budget(evaluator):
    objective = Objective(evaluator, waypoints=2, evaluations=12)
    vectors = np.random.default_rng(1).uniform(objective.low, objective.high, (12, 6))
    worth = np.append(objective.batch(vectors[:10]), [objective.one(v) for v in vectors[10:]])
    ends = evaluator.problem.start, evaluator.problem.goal
    paths = [np.array([ends[0], *vector.reshape(2, 3), ends[1]]) for vector in vectors]
    fitness = [evaluator.evaluate(path).fitness for path in paths]
    assert -worth == pytest.approx(fitness, rel=1e-12)
    assert objective.evaluations == 12
    assert np.array_equal(objective.best, paths[int(np.argmax(fitness))])
    assert objective.fitness_after(1e9) == max(-worth)
    assert objective.fitness_after(-1.0) == 0.0
    with pytest.raises(BudgetSpentError):
        objective.one(vectors[0])


def test_runs_scipy_and_names_missing_optimizers(monkeypatch, capsys):
    find_spec = importlib.util.find_spec
    others = {optimizer.package for optimizer in OPTIMIZERS.values()} - {"scipy"} | {"ompl"}
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name in others else find_spec(name)
    )
    report = peers.run(Options(seeds=1), iterations=3)
    names = [row[0] for row in report.rows]
    assert names[:2] == ["fpa-2opt", "fpa-2opt, all in full"]
    assert len(names) == 3
    assert names[2].startswith("SciPy DE ")
    row = report.rows[2]
    _, hands_over, evaluations, seconds, rate, full, judged, feasible, fitness, _, late = row
    assert hands_over == "batches"
    assert evaluations >= POPULATION
    assert rate == pytest.approx(evaluations / seconds, rel=1e-3)
    assert full > 0  # The machine decides which rate is greater.
    assert judged > 0
    assert feasible in ("0/1", "1/1")
    assert 0 < fitness <= late < 2
    assert report.notes[-1] == (
        "Not installed, so left out: deap, mealpy, ompl, pymoo (pip install '.[peers]')."
    )


@pytest.mark.parametrize("name", [name for name in OPTIMIZERS if name != "SciPy DE"])
def test_a_peer_uses_its_budget_of_evaluations(evaluator, name):
    optimizer = OPTIMIZERS[name]
    pytest.importorskip(optimizer.package, reason=f"{optimizer.package} is of the extra 'peers'")
    granted = 2 * POPULATION
    outcome = peers._optimized(optimizer, evaluator, 0, granted, 1.0)
    assert granted <= outcome.evaluations <= 2 * granted
    assert 0 < outcome.fitness < 2


@pytest.mark.parametrize("name", PLANNERS)
def test_a_planner_of_ompl_flies_free_straight_lines(evaluator, name):
    pytest.importorskip("ompl", reason="ompl is of the extra 'peers'")
    path = solve(evaluator, name, 1, 2.0)
    if path is None:
        return  # No result within the time, on a busy machine.
    ends = evaluator.problem.start, evaluator.problem.goal
    assert path[[0, -1]] == pytest.approx(np.array(ends))
    assert path.shape[1] == 3
    assert evaluator.evaluate(path).length_m < 8_000
