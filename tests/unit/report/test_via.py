"""Distances of a track from the points that it must visit."""

import math
import time

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.way import WayProblem
from pathgene.host.report.track import mark_names, marked_waypoints
from pathgene.host.report.via import visits
from pathgene.host.terrain import Terrain


START, CORNER, GOAL = (500.0, 500.0, 200.0), (3000.0, 500.0, 200.0), (3000.0, 3000.0, 200.0)


def visited(via, path):
    terrain = Terrain("plain", np.zeros((41, 41)), 100, 100)
    evaluator = Evaluator(WayProblem(terrain, (path[0], *via, path[-1])))
    return visits(evaluator, np.array(path)), evaluator


def test_a_right_angle_is_rounded_by_two_fifths_of_the_radius():
    (visit,), evaluator = visited([CORNER], [START, CORNER, GOAL])
    radius_m = evaluator.problem.limits.turn_radius_m
    assert visit.distance_m == pytest.approx((math.sqrt(2) - 1) * radius_m, rel=1e-9)
    assert visit.horizontal_m == visit.distance_m
    assert visit.at_m == pytest.approx(2500 - radius_m + math.pi / 4 * radius_m, abs=1e-3)
    assert (visit.line_m, visit.missed) == (0, False)


def test_a_point_on_a_line_needs_no_waypoint():
    via = [(1250.0, 500.0, 200.0), (3000.0, 2000.005, 200.0)]
    (first, second), _ = visited(via, [START, CORNER, GOAL])
    assert first.distance_m == pytest.approx(0, abs=1e-6)
    assert first.at_m == pytest.approx(750, abs=1e-6)
    assert not first.missed
    assert not second.missed


def test_a_point_beside_the_lines_is_missed():
    via = [(1250.0, 530.0, 240.0)]
    (visit,), _ = visited(via, [START, CORNER, GOAL])
    assert (visit.distance_m, visit.horizontal_m) == (pytest.approx(50), pytest.approx(30))
    assert visit.line_m == pytest.approx(50)
    assert visit.missed
    assert visit.sentence == (
        "The path misses via point 1 at (1250, 530, 240) by 50.0 m; it must have a waypoint there, "
        "which a turn may round."
    )


def test_an_arc_through_the_point_is_a_visit():
    """A waypoint may be placed next to a point so that its arc passes it."""
    _, evaluator = visited([CORNER], [START, CORNER, GOAL])
    inside_m = evaluator.problem.limits.turn_radius_m * (1 - math.sqrt(0.5))
    via = (3000.0 - inside_m, 500.0 + inside_m, 200.0)
    (visit,), _ = visited([via], [START, CORNER, GOAL])
    assert visit.distance_m == pytest.approx(0, abs=1e-6)
    assert visit.line_m == pytest.approx(inside_m)
    assert not visit.missed
    later = (3000.0, 2000.0, 200.0)
    found, _ = visited([later, via], [START, CORNER, GOAL])
    assert [visit.missed for visit in found] == [False, True]
    assert "in another order" in found[1].sentence


def test_points_in_another_order_are_missed():
    first, second = (2000.0, 500.0, 200.0), (1000.0, 500.0, 200.0)
    there, back = visited([first, second], [START, CORNER, GOAL])[0]
    assert (there.missed, back.missed) == (False, True)
    assert back.line_m == 0
    assert back.sentence == (
        "The path passes via point 2 at (1000, 500, 200) in another order; give the via points in "
        "its order."
    )


def test_a_point_may_be_visited_twice():
    via = (CORNER, GOAL, CORNER)
    path = [START, CORNER, GOAL, (2000.0, 3000.0, 200.0), CORNER, (3500.0, 300.0, 200.0)]
    assert [visit.missed for visit in visited(via, path)[0]] == [False] * 3
    # Once only: the second visit is missing.
    assert [visit.missed for visit in visited(via, path[:4])[0]] == [False, False, True]


def test_agrees_with_dense_samples():
    rng = np.random.default_rng(5)
    for _ in range(5):
        path = np.column_stack((rng.uniform(500, 3500, (6, 2)), rng.uniform(100, 400, 6)))
        via = tuple(map(tuple, np.column_stack((rng.uniform(500, 3500, (3, 2)), [200] * 3))))
        found, evaluator = visited(via, list(map(tuple, path)))
        samples = evaluator.track(path).sample(0.5)
        points = np.column_stack((samples.x, samples.y, samples.z))
        for visit in found:
            offsets = points - visit.point
            distances = np.linalg.norm(offsets, axis=1)
            nearest = distances.argmin()
            # With half a step between them, a sample is at most 0.25 m away from it.
            assert visit.distance_m <= distances[nearest] + 1e-9
            assert math.hypot(visit.distance_m, 0.25) >= distances[nearest] - 0.001
            assert visit.at_m == pytest.approx(samples.s[nearest], abs=0.5)
            assert visit.horizontal_m == pytest.approx(np.hypot(*offsets[nearest, :2]), abs=0.5)


A, B, C, D = (0.0, 0.0, 1.0), (9.0, 0.0, 2.0), (9.0, 9.0, 3.0), (5.0, 5.0, 4.0)


def test_names_every_mission():
    assert mark_names((A, B)) == ("Start", "Goal")
    assert mark_names((A, B, C)) == ("Start", "Via 1", "Goal")
    assert mark_names((A, B, C, D)) == ("Start", "Via 1", "Via 2", "Goal")
    assert mark_names((A, B, A)) == ("Start", "Goal", "Return")
    assert mark_names((A, B, C, A)) == ("Start", "Via 1", "Goal", "Return")


def test_finds_the_waypoints_in_the_order_of_the_mission():
    path = np.array([A, D, B, D, C, A])
    assert marked_waypoints(path, (A, B, D, C, A)) == {
        0: "Start",
        2: "Via 1",
        3: "Via 2",
        4: "Goal",
        5: "Return",
    }
    assert marked_waypoints(path, (A, A)) == {0: "Start", 5: "Goal"}


def test_a_point_that_is_missed_has_no_waypoint():
    path = np.array([A, (9.0, 0.0, 2.02), C, D])
    assert marked_waypoints(path, (A, B, C, D)) == {0: "Start", 2: "Via 2", 3: "Goal"}


def brute_force(evaluator, path, point, axes):
    """Return the minimum distance of a track from a point, over dense samples of all pieces."""
    parts = np.linspace(0, 1, 4001)
    pieces = evaluator.track(np.array(path)).pieces
    offsets = np.concatenate([piece.points(parts) - point for piece in pieces])
    return np.linalg.norm(offsets[:, :axes], axis=1).min()


def test_the_nearest_place_is_that_of_all_pieces():
    rng = np.random.default_rng(3)
    path = np.column_stack((rng.uniform(300, 3700, (12, 2)), rng.uniform(150, 900, 12)))
    via = [tuple(point) for point in (*path[1:-1:4], *np.add(path[2:6], (35.0, -20.0, 15.0)))]
    found, evaluator = visited(via, [tuple(point) for point in path])
    for visit, point in zip(found, via, strict=True):
        assert visit.distance_m == pytest.approx(brute_force(evaluator, path, point, 3), abs=0.1)


def test_a_hundred_points_take_no_time():
    """Each of 100 points is compared with a track of 4,000 pieces."""
    rng = np.random.default_rng(4)
    path = np.column_stack((rng.uniform(300, 3700, (2001, 2)), rng.uniform(150, 900, 2001)))
    via = [tuple(point) for point in path[20:2000:20]]
    _, evaluator = visited(via, [tuple(point) for point in path])
    begun_s = time.process_time()
    assert len(visits(evaluator, path)) == len(via)
    assert time.process_time() - begun_s < 5


def test_the_same_points_again_and_again():
    """Half of the legs of this mission pass each of two points."""
    one, other = (1000.0, 1000.0, 200.0), (3000.0, 3000.0, 200.0)
    path = [one, other] * 50
    _, evaluator = visited(path[1:-1], path)
    begun_s = time.process_time()
    assert not any(visit.line_m for visit in visits(evaluator, np.array(path)))
    assert time.process_time() - begun_s < 5
