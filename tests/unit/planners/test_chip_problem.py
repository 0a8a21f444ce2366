"""A problem in the chip's integers: the model's score against the evaluation."""

import dataclasses
import math
import re

import numpy as np
import pytest

from hdl.config import Config
from hdl.protocol.planner import problem_request
from hdl.protocol.runs import RunOptions
from host.errors import InputError
from host.evaluation import Evaluator
from host.evaluation.reference import problem_utopia
from host.planners.chip_problem import problem_record
from host.problem import Problem
from host.problem.aircraft import load
from host.problem.corner_map import CornerMap
from host.terrain import Terrain
from sim.model.planner.definition.score import corner_of, score
from sim.model.planner.run import plan


CONFIG = Config()


def make(*, cells=200, cell_m=50.0, north_m=None, relief_m=800.0, **changes):
    rng = np.random.default_rng(1)
    x, y = np.meshgrid(np.linspace(0, 9, cells), np.linspace(0, 7, cells))
    hills = (np.sin(x) * np.cos(y) + 1) * relief_m / 2 + rng.uniform(0, 5, size=x.shape) + 100
    terrain = Terrain("t", hills, dx_m=cell_m, dy_m=north_m or cell_m)
    wide, high = (cells - 1) * cell_m, (cells - 1) * (north_m or cell_m)
    ends = [(0.1 * wide, 0.1 * high), (0.9 * wide, 0.9 * high)]
    start, goal = ((*end, float(terrain.ground(*end)) + 100) for end in ends)
    problem = Problem(terrain, start, goal, as_paper=True, **changes)
    grid = CornerMap(CONFIG, problem)
    return problem, grid, problem_record(CONFIG, problem, grid)


@pytest.mark.parametrize(
    "terrain",
    [{}, {"north_m": 80.0}, {"cell_m": 10.0}, {"cells": 700}, {"cell_m": 400.0, "relief_m": 4000}],
    ids=["usual", "oblong", "fine", "compressed", "coarse"],
)
def test_the_score_is_the_evaluation_of_a_feasible_path(terrain):
    """The cost of whatever the model finds feasible, in units of eq. (2), within half a percent."""
    problem, grid, record = make(**terrain)
    assert len(record.pack(CONFIG)) == problem_request(CONFIG).size
    outcome = plan(CONFIG, grid.corners(), record, RunOptions(seed=1, cycles=300_000))
    evaluator = Evaluator(problem, threads=1)
    best = problem_utopia(problem)
    unit_m = max(grid.scale_m) / 256
    area = 2 * best.altitude_m * best.length_m / (grid.step_m / 16 * unit_m)
    ends = corner_of(record, "start"), corner_of(record, "goal")
    feasible = 0
    for waypoints in outcome.paths:
        metres = grid.corners_to_metres(np.array(waypoints))
        evaluation = evaluator.evaluate(np.vstack((problem.start, metres, problem.goal)))
        feasible += evaluation.feasible
        scored = score(record, [ends[0], *waypoints, ends[1]])
        assert scored.cost / area / 2 == pytest.approx(evaluation.cost, rel=5e-3)
    assert feasible


def test_limits_are_rounded_to_the_stricter_side():
    problem, grid, record = make()
    unit_m, part_m = 50.0 / 256, grid.step_m / 16
    assert record.radius * unit_m >= problem.limits.turn_radius_m > (record.radius - 1) * unit_m
    for slope, degrees in ((record.climb, 10.0), (record.descent, 30.0)):
        tangent = math.tan(math.radians(degrees))
        assert slope / 4096 * part_m / unit_m <= tangent < (slope + 1) / 4096 * part_m / unit_m
    assert record.start_altitude * part_m + grid.base_m <= problem.start[2]


def test_in_wind_the_slopes_are_those_of_the_worst_direction():
    problem, _, calm = make()
    changes = {"as_paper": False, "wind": (8.0, 3.0)}
    windy = Problem(problem.terrain, problem.start, problem.goal, **changes)
    grid = CornerMap(CONFIG, windy)
    record = problem_record(CONFIG, windy, grid)
    to_tangents = grid.step_m / 16 / (50.0 / 256) / 4096
    directions = np.linspace(0, 2 * np.pi, 10_000)
    limits = windy.slope_limits(np.cos(directions), np.sin(directions))
    for slope, before, limit in zip(
        (record.climb, record.descent), (calm.climb, calm.descent), limits, strict=True
    ):
        assert slope * to_tangents == pytest.approx(limit.min(), rel=1e-3)
        assert slope < 0.8 * before


def test_ends_lie_between_the_corners():
    problem, _, record = make()
    assert record.start_x == round((problem.start[0] / 50.0 - 0.5) * 256)
    assert record.goal_y == round((problem.goal[1] / 50.0 - 0.5) * 256)


def test_an_end_at_the_edge_of_the_map_is_moved_to_the_nearest_corner():
    problem, _, _ = make()
    terrain = problem.terrain
    start, goal = ((x, 10.0, float(terrain.ground(x, 10.0)) + 50) for x in (0.0, 199 * 50.0))
    moved = Problem(terrain, start, goal, as_paper=True)
    record = problem_record(CONFIG, moved, CornerMap(CONFIG, moved))
    assert (record.start_x, record.start_y) == (0, 0)
    assert record.goal_x == 198 << 8


def test_a_vertical_climber_has_the_steepest_slope_of_the_record():
    aircraft = dataclasses.replace(load("silver-fox"), max_climb_deg=90.0)
    _, _, record = make(aircraft=aircraft)
    assert record.climb == (1 << 24) - 1


@pytest.mark.parametrize(
    ("terrain", "message"),
    [
        (
            {"cell_m": 0.1, "relief_m": 4.0},
            "The turning radius of 150 m is more than 1,024 cells of the chip's map; "
            "take a coarser terrain.",
        ),
        (
            {"cell_m": 0.2, "relief_m": 30_000.0},
            "The chip's altitude step of 8.0625 m is a cell or more; take a coarser terrain.",
        ),
    ],
)
def test_a_problem_too_fine_for_the_record_is_refused(terrain, message):
    with pytest.raises(InputError, match=f"^{re.escape(message)}$"):
        make(**terrain)
