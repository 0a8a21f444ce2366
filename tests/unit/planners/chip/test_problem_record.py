"""A problem in the chip's integers: the model's score compared with the evaluation."""

import dataclasses
import math
import re

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.planner import PathClass, problem_request
from pathgene.hdl.protocol.runs import RunOptions
from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.geometry import smooth
from pathgene.host.evaluation.reference import problem_utopia
from pathgene.host.planners.chip.problem_record import committed_points, problem_record, whole_path
from pathgene.host.problem.aircraft import load
from pathgene.host.problem.corner_map import CornerMap
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.surface import surface_below
from pathgene.sim.model.planner.definition.score import corner_of, score
from pathgene.sim.model.planner.run import plan


CONFIG = Config()
NO_MARGINS = Rules(clearance_m=0, corridor_m=0, zone_margin_m=0, reserve=0)


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
    """Costs of paths that the model finds feasible equal eq. (2) within half a percent."""
    problem, grid, record = make(**terrain)
    assert len(record.pack(CONFIG)) == problem_request(CONFIG).size
    outcome = plan(CONFIG, grid.corners(), record, RunOptions(seed=1, cycles=1_000_000))
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
            {"cell_m": 0.2, "relief_m": 8700.0},
            "The chip's altitude step of 2.34375 m is a cell or more; take a coarser terrain.",
        ),
    ],
)
def test_a_problem_too_fine_for_the_record_is_refused(terrain, message):
    with pytest.raises(InputError, match=f"^{re.escape(message)}$"):
        make(**terrain)


def headed(start_deg=None, goal_deg=None, **changes):
    """The usual problem with headings, under rules without further requirements."""
    problem, _, _ = make()
    problem = Problem(
        problem.terrain, problem.start, problem.goal, rules=NO_MARGINS,
        start_heading_deg=start_deg, goal_heading_deg=goal_deg, **changes,
    )  # fmt: skip
    grid = CornerMap(CONFIG, problem)
    return problem, grid, problem_record(CONFIG, problem, grid)


@pytest.mark.parametrize(
    ("start_deg", "goal_deg"), [(45, None), (200, None), (None, 135), (300, 330)]
)
def test_a_path_that_the_chip_finds_feasible_keeps_the_headings(start_deg, goal_deg):
    problem, grid, record = headed(start_deg, goal_deg)
    outcome = plan(CONFIG, grid.corners(), record, RunOptions(seed=1, cycles=600_000))
    evaluator = Evaluator(problem, threads=1)
    assert outcome.classes[0] is PathClass.FEASIBLE
    verdicts = []
    for waypoints in outcome.paths:
        path = whole_path(problem, grid.corners_to_metres(np.array(waypoints)))
        verdicts.append(evaluator.evaluate(path))
        # There is no turn at the ends themselves.
        pieces = smooth(path, problem.limits.turn_radius_m, problem.headings).pieces
        assert pieces[0].start == pytest.approx(problem.start)
        for piece, heading in zip((pieces[0], pieces[-1]), problem.headings, strict=True):
            assert heading is None or piece.heading == pytest.approx(heading)
    assert any(verdict.feasible for verdict in verdicts)
    best = next(verdict for verdict in verdicts if verdict.feasible)
    utopia = problem_utopia(problem)
    area = 2 * utopia.altitude_m * utopia.length_m / (grid.step_m / 16 * max(grid.scale_m) / 256)
    costs = [outcome.keys[verdicts.index(best)] << record.key_shift]
    assert costs[0] / area / 2 == pytest.approx(best.cost, rel=5e-3)


def test_a_committed_point_is_a_turning_radius_ahead():
    problem, grid, record = headed(90, 0)
    first, last = committed_points(problem)
    radius_m = problem.limits.turn_radius_m
    (x, y, z), (u, v, w) = problem.start, problem.goal
    assert first == pytest.approx((x + 1.1 * radius_m, y, z))
    # South of the goal, where the aircraft arrives heading north.
    assert last[:2] == pytest.approx((u, v - 1.1 * radius_m))
    assert last[2] >= w
    assert (record.has_entry, record.has_exit) == (1, 1)
    assert record.start_x == round((first[0] / 50.0 - 0.5) * 256)
    assert record.entry_x == round((x / 50.0 - 0.5) * 256)
    assert record.exit_y == round((v / 50.0 - 0.5) * 256)
    assert record.entry_altitude == math.floor((z - grid.base_m) / grid.step_m * 16)


def test_without_headings_there_is_no_committed_point():
    problem, _, record = make()
    assert committed_points(problem) == (None, None)
    assert (record.has_entry, record.has_exit) == (0, 0)
    waypoints = np.array([[500.0, 600.0, 700.0]])
    assert whole_path(problem, waypoints).tolist() == [
        list(problem.start), [500.0, 600.0, 700.0], list(problem.goal),
    ]  # fmt: skip


def test_a_committed_point_rises_with_the_ground_within_the_climb_limit():
    slope = np.tile(np.arange(100.0) * 50.0 * 0.1, (100, 1))
    cliff = np.where(np.arange(100) < 50, slope, slope + 900)
    problem = Problem(
        Terrain("t", cliff, dx_m=50.0, dy_m=50.0), (1000, 2500, 101), (4500, 2500, 2500),
        rules=NO_MARGINS, start_heading_deg=90,
    )  # fmt: skip
    # 1 m above ground that rises by a tenth: the line there touches the squares of the nodes.
    first, _ = committed_points(problem)
    share = np.arange(1, 65) / 64
    x = 1000 + share * (first[0] - 1000)
    below = surface_below(problem.terrain, x, np.full_like(x, 2500.0))
    assert (101 + share * (first[2] - 101) - below).min() == pytest.approx(0, abs=1e-9)
    before = dataclasses.replace(problem, start=(2400.0, 2500.0, 250.0))
    first, _ = committed_points(before)
    steepest = 0.98 * math.tan(problem.limits.climb_rad) * (first[0] - 2400)
    assert first[2] - 250 == pytest.approx(steepest)


def test_a_committed_point_stays_on_the_map():
    problem, _, _ = headed()
    start = (9900.0, 5000.0, float(problem.terrain.ground(9900.0, 5000.0)) + 90)
    problem = dataclasses.replace(problem, start=start, start_heading_deg=90)
    first, _ = committed_points(problem)
    assert first[0] == pytest.approx(problem.terrain.width_m)
    # The aircraft turns there, with the corridor beside it.
    with_corridor = dataclasses.replace(problem, rules=Rules(zone_margin_m=0, clearance_m=0))
    first, _ = committed_points(with_corridor)
    assert first[0] == pytest.approx(problem.terrain.width_m - 25)


def test_a_committed_point_climbs_over_no_blocked_node():
    flat = Terrain("t", np.full((100, 100), 10.0), dx_m=30.0, dy_m=30.0)
    # Along the edge, 27 m from it: far from the end, the nodes there are blocked.
    problem = Problem(flat, (300, 27, 90), (1500, 1500, 90), rules=Rules(), start_heading_deg=90)
    assert np.isnan(problem.surface.elevation[0, 16])
    first, _ = committed_points(problem)
    assert first == pytest.approx((300 + 1.1 * problem.limits.turn_radius_m, 27, 90))
