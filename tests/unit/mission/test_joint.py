"""A leg evaluated together with the end of the leg before it."""

import math

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.mission.joint import JoinedEvaluator
from pathgene.host.mission.mission import Mission
from pathgene.host.problem.problem import Problem
from pathgene.host.report.via import visits
from pathgene.host.terrain import Terrain


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


def test_a_leg_does_not_turn_back_at_the_via_point_by_one_arc():
    """The arc has room, and would begin a kilometre ahead of the point."""
    terrain = Terrain("flat", np.full((31, 61), 100.0), 100, 100)
    start, via, goal = (500.0, 1500.0, 300.0), (5000.0, 1500.0, 300.0), (500.0, 2000.0, 300.0)
    mission = Mission(Problem(terrain, start, goal), [via])
    ahead = np.array([start])
    leg = mission.leg(1, start_heading_deg=90)
    joined = JoinedEvaluator(leg, ahead, mission.part((start, via, goal)))
    whole = Evaluator(mission.whole)
    radius_m = leg.limits.turn_radius_m
    right = (5000.0, 1900.0, 300.0)
    for path, back_rad in (
        (np.array([via, goal]), 0.5 * math.pi - math.atan2(500, 4500)),
        (np.array([via, (4900.0, 2000.0, 300.0), goal]), math.atan2(100, 500)),
        (np.array([via, right, goal]), 0.0),
    ):
        together = whole.evaluate(np.concatenate((ahead, path)))
        assert together.feasible
        found = joined.evaluate(path)
        assert found.penalty == pytest.approx(radius_m * back_rad)
        assert found.feasible is (back_rad == 0)
        lengths = np.array([len(path)])
        for strict in (False, True):
            fitness = joined.fitness(path[None], lengths, strict=strict)
            assert fitness == pytest.approx([found.fitness])
        assert joined.penalty_cost(path[None], lengths, fine=True)[0] == pytest.approx(
            [found.penalty]
        )
        (visit,) = visits(whole, np.concatenate((ahead, path)))
        assert visit.missed is (back_rad > 0)
        if visit.missed:
            assert visit.horizontal_m > 0.42 * radius_m
            assert visit.sentence.startswith("The path turns back at via point 1 at (5000, 1500, 3")


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
