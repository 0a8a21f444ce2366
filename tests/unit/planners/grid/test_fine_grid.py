"""Search over smaller nodes than the quick searches have."""

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.planners.base import Options, Run
from pathgene.host.planners.grid.astar import AstarPlanner, fine_searches
from pathgene.host.planners.grid.fine_grid import fine_grid
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Polygon
from pathgene.host.terrain import Terrain


def evaluator(gap_m, *, nodes=401, rules=None, as_paper=True):
    """A wall of zones across the map, with a gap beside the straight line."""
    side_m = 40.0
    terrain = Terrain("t", np.zeros((nodes, nodes)), side_m, side_m)
    width = (nodes - 1) * side_m
    low, high = 0.62 * width, 0.62 * width + gap_m
    west, east, north = 0.5 * width, 0.53 * width, width - 1_000
    walls = [
        Polygon(((west, bottom), (east, bottom), (east, top), (west, top)))
        for bottom, top in ((-100.0, low), (high, north))
    ]
    ends = (1_000.0, 0.4 * width, 150.0), (width - 1_000.0, 0.4 * width, 150.0)
    problem = Problem(terrain, *ends, zones=walls, rules=rules, as_paper=as_paper)
    return Evaluator(problem, threads=1)


def best_of(own):
    found = [pair for some in fine_searches(Run(own, Options()), 32) for pair in some]
    fitness, path = max(found, key=lambda pair: pair[0])
    evaluation = own.evaluate(path)
    assert evaluation.feasible
    assert evaluation.fitness == pytest.approx(fitness)
    assert len(path) - 2 <= 32
    return evaluation, path


@pytest.mark.parametrize(
    ("gap_m", "most_y"), [(200.0, 10_500.0), (100.0, 10_500.0), (60.0, 15_500.0)]
)
def test_finds_what_the_quick_searches_do_not(gap_m, most_y):
    """A gap of 100 m is flown through; where it is too narrow, the path goes round the wall."""
    own = evaluator(gap_m, rules=Rules(clearance_m=20), as_paper=False)
    assert not AstarPlanner().plan(own, Options(generations=40)).evaluation.feasible
    _, path = best_of(own)
    assert most_y - 1_000 < path[:, 1].max() < most_y


def test_is_better_where_the_quick_searches_find_a_path():
    own = evaluator(100.0)
    quick = AstarPlanner().plan(own, Options(generations=40)).evaluation
    assert quick.feasible
    assert best_of(own)[0].fitness > quick.fitness + 0.001


@pytest.mark.parametrize(("nodes", "searches"), [(200, 1), (401, 3), (1025, 0)])
def test_terrain_of_few_nodes_is_searched_along_tangents_only(nodes, searches):
    found = list(fine_searches(Run(evaluator(400.0, nodes=nodes), Options()), 32))
    assert len(found) == searches


def test_nodes_are_the_cells_or_parts_of_them():
    problem = evaluator(400.0, nodes=61).problem
    assert fine_grid(problem, 256).shape == (61, 61)
    assert fine_grid(problem, 200, 3).shape == (181, 181)
    assert fine_grid(evaluator(400.0).problem, 256).shape == (201, 201)
