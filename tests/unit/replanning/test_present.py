"""The current air judges tracks as the evaluator judges paths."""

import dataclasses
import math

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.replanning.present import Present
from pathgene.host.replanning.tracks import Pose, end_of, part, run_of


def present(mission, *zones, wind=(0.0, 0.0), goal=None):
    return Present(mission, zones, goal or mission.goal, wind)


def test_tracks_of_paths_are_judged_as_the_paths(mission):
    """For random paths, a track is safe if the evaluator finds no fault with ground and zones."""
    rng = np.random.default_rng(4)
    zones = (Circle(3500.0, 4700.0, 300.0), Polygon([(5000, 4000), (5400, 4100), (5200, 4600)]))
    problem = dataclasses.replace(mission, zones=zones)
    evaluator, air = Evaluator(problem, threads=1), present(mission, *zones)
    verdicts = []
    for _ in range(200):
        middle = rng.uniform((2000, 3700, 190), (6000, 5300, 290), size=(2, 3))
        path = np.vstack((problem.start, middle[np.argsort(middle[:, 0])], problem.goal))
        found = evaluator.evaluate(path)
        track = evaluator.track(path).pieces
        assert air.off_limits_m(track) == pytest.approx(found.distance_under_terrain_m, abs=1e-6)
        assert air.in_zones_m(track) == pytest.approx(found.distance_in_nofly_m, abs=1e-6)
        verdicts.append(air.is_safe(track))
    assert 20 < sum(verdicts) < 180


def test_a_track_is_safe_until_shortly_before_a_zone(mission, straight):
    track = Evaluator(mission, threads=1).track(straight).pieces
    air = present(mission, Circle(4000.0, 4500.0, 200.0))
    # The border with the margin lies 2,275 m from the start.
    assert 2225 - 50 <= air.safe_until_m(track, 0.0) <= 2275
    assert air.is_safe(part(track, 0.0, air.safe_until_m(track, 0.0)))
    assert air.safe_until_m(track, 2800.0) == math.inf
    assert present(mission).safe_until_m(track, 0.0) == math.inf


def test_a_track_is_safe_until_a_zone_that_is_active_when_the_track_reaches_it(mission, straight):
    """The straight track reaches the first zone after some 90 s, the second after some 150 s."""
    track = Evaluator(mission, threads=1).track(straight).pieces
    over_by_then = Circle(4000.0, 4500.0, 200.0, t0_s=0.0, t1_s=60.0)
    active_by_then = Circle(5400.0, 4500.0, 200.0, t0_s=60.0, t1_s=600.0)
    air = present(mission, over_by_then, active_by_then)
    # The border with the margin of the second zone lies 3,675 m from the start.
    assert 3675 - 50 <= air.safe_until_m(track, 0.0) <= 3675


def test_zones_and_their_margins(mission):
    air = present(mission, Circle(4000.0, 4500.0, 200.0), Circle(4100.0, 4500.0, 200.0))
    beside = Pose(3790.0, 4500.0, 250.0, 1.0, 0.0, 0.0)
    assert air.zones_at(beside) == {0}
    assert air.zones_at(beside, margin=False) == set()
    both = (Pose(4000.0, 4500.0, 250.0, 1.0, 0.0, 0.0).straight(10.0),)
    assert air.in_zones_m(both) == pytest.approx(20)
    assert air.in_zones_m(both, among=[1]) == pytest.approx(10)
    assert not air.is_goal_in_zone
    covered = present(mission, Circle(*mission.goal[:2], 50.0))
    assert covered.is_goal_in_zone


def test_ceilings_and_the_edge_of_the_map_count(mission):
    ceiling = dataclasses.replace(mission, rules=dataclasses.replace(mission.rules, ceiling_m=300))
    level = Pose(3000.0, 4500.0, 290.0, 1.0, 0.0, 0.0)
    assert present(ceiling).is_safe((level.straight(500.0),))
    assert not present(ceiling).is_safe((level.straight(500.0, 0.1),))
    assert not present(mission).is_safe((level.straight(9_000.0),))
    far = Pose(1e9, 0.0, 290.0, 1.0, 0.0, 0.0)
    assert not present(mission).is_safe((far.straight(10.0),))


def test_a_circle_keeps_the_corridor_on_the_map(mission):
    """A circle near the west edge, flown in both directions; the rim is outside the circle."""
    air, radius_m = present(mission), 1.1 * 150.0
    for away_m, share, is_on_map in (
        (25.01, 1.0, True),
        (24.99, 1.0, False),
        (12.51, 0.5, True),
        (12.49, 0.5, False),
    ):
        for side in (1, -1):
            at = Pose(radius_m + away_m, 4500.0 - side * radius_m, 290.0, 1.0, 0.0, 0.0)
            circle = []
            for _ in range(4):
                circle.append(at.arc(radius_m, side * 0.5 * math.pi))
                at = end_of(circle[-1])
            assert (air.off_limits_m(circle, share) == 0) == is_on_map, (away_m, side)


def test_wind_widens_turns_and_changes_climbs(mission):
    calm, windy = present(mission), present(mission, wind=(8.0, 0.0))
    assert windy.turn_radius_m == pytest.approx(calm.turn_radius_m * (1 + 8 / 23) ** 2)
    assert windy.speeds_m_s == pytest.approx((15.0, 31.0))
    ahead = Pose(3000.0, 4500.0, 290.0, 1.0, 0.0, 0.0)
    assert windy.climb(ahead) < calm.climb(ahead)
    assert run_of((ahead.straight(5.0),)) == 5


def test_tracks_are_judged_where_costs_are_not_defined(mission, straight):
    """The line from the mission's start to a new goal may be a glide that burns no fuel."""
    track = Evaluator(mission, threads=1).track(straight).pieces
    usual = present(mission)
    for goal in ((1700.0, 4500.0, 170.0), (1500.0, 4500.0, 220.0)):
        air = present(mission, goal=goal)
        # It is far from the goals.
        beyond = part(track, 3000.0, 4000.0)
        assert air.off_limits_m(beyond) == usual.off_limits_m(beyond) == 0
        assert air.safe_until_m(part(track, 3000.0, 4000.0), 0.0) == math.inf
