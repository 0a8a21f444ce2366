"""A leg evaluated together with the end of the leg before it."""

import numpy as np
import pytest

from host.evaluation import Evaluator
from host.mission.joint import JoinedEvaluator
from host.mission.mission import Mission
from host.problem import Problem
from host.terrain import Terrain


START, VIA, GOAL = (500.0, 500.0, 300.0), (2000.0, 500.0, 300.0), (500.0, 2500.0, 300.0)
#: Back over the shoulder: the arc at the via point needs more room than 200 m.
SHARP = np.array([VIA, (1200.0, 900.0, 300.0), GOAL])
WIDE = np.array([VIA, (2100.0, 1500.0, 300.0), (1500.0, 2400.0, 300.0), GOAL])


@pytest.fixture(params=[False, True], ids=["rules", "paper"])
def evaluators(request):
    terrain = Terrain("flat", np.full((31, 41), 100.0), 100, 100)
    mission = Mission(Problem(terrain, START, GOAL, as_paper=request.param), [VIA])
    ahead = np.array([START, (1800.0, 500.0, 300.0)])
    leg = mission.leg(1, start_heading_deg=90)
    joined = JoinedEvaluator(leg, ahead, mission.part((*map(tuple, ahead), VIA, GOAL)))
    return joined, Evaluator(mission.whole), ahead


def test_the_arc_at_the_via_point_needs_room_on_both_sides(evaluators):
    joined, whole, ahead = evaluators
    for path, feasible in ((SHARP, False), (WIDE, True)):
        together = whole.evaluate(np.concatenate((ahead, path)))
        assert together.feasible is feasible
        found = joined.evaluate(path)
        assert found.feasible is feasible
        assert found.impossible_arcs == together.impossible_arcs
        assert found.length_m == together.length_m


def test_populations_are_evaluated_the_same_way(evaluators):
    joined, _, _ = evaluators
    paths = np.zeros((2, 4, 3))
    paths[0, :3], paths[1] = SHARP, WIDE
    lengths = np.array([3, 4])
    fitness = joined.fitness(paths, lengths)
    for value, path in zip(fitness, (SHARP, WIDE), strict=True):
        assert value == pytest.approx(joined.evaluate(path).fitness)
    penalty, _ = joined.penalty_cost(paths, lengths, fine=True)
    assert penalty[0] > 0
    assert penalty[1] == 0
    counted = joined.fitness_counted(paths, lengths, np.zeros(2))
    assert (counted > 1).tolist() == [False, True]
