"""The yardstick of replans finds a path where any planner does, in no time."""

import pytest

from bench.planted import planted
from bench.replan_scenarios import draw_mission
from bench.yardstick import Yardstick
from pathgene.hdl.config import GeneticCore
from pathgene.host.device.boards import open_board, with_core
from pathgene.host.evaluation import Evaluator
from pathgene.host.replanning.planner import InFlightPlanner


pytestmark = pytest.mark.ci  # Plans by all planners.


@pytest.fixture(scope="module")
def chip():
    with open_board(with_core("model:", GeneticCore.PLANNER)) as board:
        yield board


def attempts(problem, chip):
    """Return attempts of astar in flight and of the yardstick."""
    found = []
    for planner in (InFlightPlanner("astar", seconds=0.0), Yardstick(chip, seed=2)):
        planner.prepare(Evaluator(problem, threads=1))
        found.append(planner.attempt(problem, 0))
    assert found[1].time.total_s == 0.0
    return found


def test_a_maze_that_astar_in_flight_does_not_solve(chip):
    alone, best = attempts(planted("maze", 0).problem, chip)
    assert alone.plan is None
    assert best.plan is not None
    assert best.plan.evaluation.feasible


def test_a_path_at_least_as_good_as_astars(chip, monkeypatch):
    monkeypatch.setattr("bench.replan_scenarios.terrains", lambda: ["canyon"])
    mission = draw_mission(3)
    alone, best = attempts(mission, chip)
    assert best.plan.evaluation.fitness >= alone.plan.evaluation.fitness - 1e-4
