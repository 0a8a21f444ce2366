"""Planners near the edge of the map, judged by dense samples."""

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.planning import Search
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Polygon
from pathgene.host.terrain import Terrain
from tests.support.host.flight_oracle import examine


SIDE_M = 3000.0
PLANNERS = {
    "astar": {},
    "ga-pc": {"generations": 40},
    "fpa-2opt": {"generations": 60},
    "ga-chip": {"board": "model:?core=planner", "chip_ms": 4},
}


def planned(planner, cell_m, start, goal, zones=(), **rules):
    """Return the problem, the path and its verdict."""
    nodes = round(SIDE_M / cell_m) + 1
    ground = 100 + 20 * np.random.default_rng(1).random((nodes, nodes))
    terrain = Terrain("rough", ground, cell_m, cell_m)
    ends = [(*end, float(terrain.ground(*end)) + 60) for end in (start, goal)]
    problem = Problem(terrain, *ends, zones=zones, rules=Rules(**rules))
    options = {"seed": 1, **PLANNERS[planner]}
    result = Search(planner, **options).run(Evaluator(problem, threads=1)).result
    return problem, result.path, result.evaluation.feasible


def is_kept(problem, path):
    """Return whether dense samples reject nothing."""
    return not examine(problem, path).rejected


@pytest.mark.parametrize("planner", PLANNERS)
@pytest.mark.parametrize("cell_m", [10.0, 30.0, 100.0])
@pytest.mark.parametrize("away_m", [26.0, 30.0])
def test_ends_beyond_the_corridor_from_the_edge_are_planned(planner, cell_m, away_m):
    problem, path, feasible = planned(planner, cell_m, (away_m, 1600.0), (2000.0, SIDE_M - away_m))
    assert feasible
    assert is_kept(problem, path)


@pytest.mark.parametrize("cell_m", [10.0, 30.0])
@pytest.mark.parametrize("away_m", [5.0, 20.0])
def test_from_an_end_nearer_than_the_corridor_a_path_leads_inwards(cell_m, away_m):
    problem, path, feasible = planned("astar", cell_m, (away_m, 1600.0), (2000.0, 1000.0))
    assert feasible
    assert is_kept(problem, path)


@pytest.mark.parametrize("planner", ["astar", "ga-chip"])
def test_a_gap_along_the_edge_is_passed_in_its_middle(planner):
    """The zone and its margin leave 150 m along the south edge; the corridor needs 25 of them."""
    wall = Polygon(((1400, 175), (1600, 175), (1600, 4000), (1400, 4000)))
    ends = (500.0, 400.0), (2500.0, 400.0)
    problem, path, feasible = planned(planner, 10.0, *ends, zones=[wall])
    assert feasible
    assert is_kept(problem, path)
    # All of the gap is nearer to the edge than this corridor.
    _, _, feasible = planned(planner, 10.0, *ends, zones=[wall], corridor_m=160.0)
    assert not feasible
