"""Plans among zones with active times, checked with the track's own times and shapely."""

from dataclasses import replace

import numpy as np
import pytest
from shapely.geometry import Point, Polygon

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Options
from pathgene.host.planners.grid.astar import AstarPlanner
from pathgene.host.planners.timed import plan_in_time, plan_together_in_time
from pathgene.host.planning import Search
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain


LEVEL = Terrain("level", np.full((61, 101), 100.0), 100.0, 100.0)
AIRSPEED_M_S = 23.0
PLANNERS = {
    "astar": {},
    "ga-pc": {"generations": 60},
    "fpa": {"generations": 60},
    "ga-chip": {"board": "model:", "generations": 60},
}


def wall(x, **times):
    return Zone.polygon([(x, -500), (x + 600, -500), (x + 600, 6500), (x, 6500)], **times)


def plan(name, zones):
    problem = Problem(LEVEL, (1000, 3000, 200), (9000, 3000, 200), zones=zones)
    evaluator = Evaluator(problem, threads=1)
    assert problem.aircraft.cruise_speed_m_s == AIRSPEED_M_S
    return Search(name, **PLANNERS[name]).run(evaluator)


def is_ever_inside(found, zones):
    """Return whether a track in calm air is in a zone while it is active, sampled every metre."""
    points = found.evaluator.track(found.path).sample(1.0)
    steps = np.hypot(np.hypot(np.diff(points.x), np.diff(points.y)), np.diff(points.z))
    seconds = np.append(0.0, np.cumsum(steps)) / AIRSPEED_M_S
    for zone in zones:
        shape = Polygon(zone.footprint.rings[0])
        active = (seconds >= (zone.t0_s or 0)) & (seconds <= (zone.t1_s or np.inf))
        places = zip(points.x[active], points.y[active], strict=True)
        if any(shape.contains(Point(place)) for place in places):
            return True
    return False


@pytest.mark.parametrize("name", PLANNERS)
def test_flies_through_a_zone_that_is_not_active_at_the_passage(name):
    for times in ({"t0_s": 0, "t1_s": 60}, {"t0_s": 600, "t1_s": 900}):
        zones = [wall(4000, **times)]
        found = plan(name, zones)
        assert found.evaluation.feasible
        assert not is_ever_inside(found, zones)
        assert is_ever_inside(found, [wall(4000)])


@pytest.mark.parametrize("name", PLANNERS)
def test_flies_around_a_zone_that_is_active_at_the_passage(name):
    square = [(4400, 2400), (5600, 2400), (5600, 3600), (4400, 3600)]
    zones = [Zone.polygon(square, t0_s=100, t1_s=400), wall(7000, t0_s=0, t1_s=150)]
    found = plan(name, zones)
    assert found.evaluation.feasible
    assert not is_ever_inside(found, zones)


def test_no_path_holds_where_all_of_the_way_is_closed():
    found = plan("astar", [wall(4000, t0_s=0, t1_s=2000)])
    assert not found.evaluation.feasible


def test_leaves_a_zone_that_becomes_active_later():
    start = [(500, 2500), (1500, 2500), (1500, 3500), (500, 3500)]
    found = plan("astar", [Zone.polygon(start, t0_s=120)])
    assert found.evaluation.feasible
    assert found.evaluation.length_m < 8100


@pytest.mark.parametrize(
    "limits", [{"upper_m": 3000}, {"lower_m": 180}, {"lower_m": 50, "upper_m": 3000}]
)
def test_a_zone_with_heights_is_ignored_while_it_is_not_active(limits):
    later = plan("astar", [wall(4000, t0_s=5000, **limits)])
    assert np.array_equal(later.path, plan("astar", []).path)


def test_tiles_of_a_zone_that_is_entered_are_avoided_together(monkeypatch):
    searches = []
    planned = AstarPlanner.plan
    monkeypatch.setattr(
        AstarPlanner, "plan", lambda *given: searches.append(given) or planned(*given)
    )
    hills = 100.0 + 40.0 * np.sin(np.arange(101) / 3)[None, :] * np.ones((61, 1))
    terrain = Terrain("hills", hills, 100.0, 100.0)
    square = [(4000, 1000), (6000, 1000), (6000, 5000), (4000, 5000)]
    zone = replace(Zone.polygon(square, t0_s=10), upper_agl_m=900.0)
    problem = Problem(terrain, (1000, 3000, 200), (9000, 3000, 200), zones=[zone])
    assert len(problem.zones) > 20
    found = Search("astar").run(Evaluator(problem, threads=1))
    assert found.evaluation.feasible
    assert len(searches) == 2


def test_several_problems_are_searched_in_rounds():
    square = [(4400, 2400), (5600, 2400), (5600, 3600), (4400, 3600)]
    cases = [
        [Zone.polygon(square, t0_s=100, t1_s=400), wall(7000, t0_s=0, t1_s=150)],
        [wall(4000, t0_s=600, t1_s=900)],
        [Zone.polygon(square)],
    ]
    ends = (1000, 3000, 200), (9000, 3000, 200)
    evaluators = [Evaluator(Problem(LEVEL, *ends, zones=zones), threads=1) for zones in cases]
    options = [Options(generations=40, seed=seed) for seed in range(3)]
    rounds = []

    def together(some, options):
        rounds.append([each.seed for each in options])
        planner = AstarPlanner()
        return [planner.plan(*each) for each in zip(some, options, strict=True)]

    found = plan_together_in_time(together, evaluators, options)
    assert rounds == [[0, 1, 2], [0]]
    for each, evaluator, own in zip(found, evaluators, options, strict=True):
        alone = plan_in_time(AstarPlanner(), evaluator, own)
        assert each.evaluation.feasible
        assert np.array_equal(each.path, alone.path)
