"""Routes out of zones, and holding circles: safe in the current air, short and late."""

import itertools
import math

import numpy as np
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.replanning.evasion import holding_on, shortest_way_out_m, way_on, way_out
from pathgene.host.replanning.present import Present
from pathgene.host.replanning.tracks import Pose, end_of, part, pose_at, run_of
from pathgene.host.terrain import Terrain


def present(mission, *zones):
    return Present(mission, zones, mission.goal, (0.0, 0.0))


def brute_way_out_m(zone, pose, radius):
    """Return the shortest turn and straight line out of a circle, by small steps."""
    best = math.inf
    for side in (1, -1):
        x, y, east, north, flown = pose.x, pose.y, pose.east, pose.north, 0.0
        while flown < math.pi * radius:
            away = np.array((x - zone.x_m, y - zone.y_m))
            along = away @ (east, north)
            left = -along + math.sqrt(max(along**2 - away @ away + zone.radius_m**2, 0.0))
            best = min(best, flown + left)
            if away @ away > zone.radius_m**2:
                best = min(best, flown)
                break
            step = 0.5
            turn = side * step / radius
            east, north = (
                east * math.cos(turn) - north * math.sin(turn),
                north * math.cos(turn) + east * math.sin(turn),
            )
            x, y, flown = x + step * east, y + step * north, flown + step
    return best


def test_the_shortest_way_out_is_that_of_small_steps(mission):
    rng = np.random.default_rng(8)
    for _ in range(25):
        zone = Circle(4000.0, 4500.0, float(rng.uniform(60, 900)))
        angle, share = rng.uniform(0, 2 * math.pi), math.sqrt(rng.uniform(0, 1))
        turn = rng.uniform(0, 2 * math.pi)
        pose = Pose(
            4000.0 + share * zone.radius_m * math.cos(angle),
            4500.0 + share * zone.radius_m * math.sin(angle),
            260.0,
            math.cos(turn),
            math.sin(turn),
            0.0,
        )
        air = present(mission, zone)
        expected = brute_way_out_m(zone, pose, air.turn_radius_m)
        assert shortest_way_out_m(air, pose) == pytest.approx(expected, rel=0.01, abs=3)
        way = way_out(air, pose)
        assert pose_at(way, 0).point == pytest.approx(pose.point)
        assert air.is_safe((end_of(way[-1]).straight(1.0),))
        inside = air.in_zones_m(way, margin=False)
        assert inside <= 1.1 * expected + 5
    assert shortest_way_out_m(air, Pose(100.0, 4500.0, 260.0, 1.0, 0.0, 0.0)) == 0


def test_a_way_out_of_two_zones_leaves_both(mission):
    air = present(
        mission,
        Circle(4000.0, 4500.0, 300.0),
        Polygon([(4200, 4200), (5000, 4200), (5000, 4900), (4200, 4900)]),
    )
    way = way_out(air, Pose(4150.0, 4500.0, 260.0, 1.0, 0.0, 0.0))
    end = end_of(way[-1])
    assert air.zones_at(end) == set()
    # West is nearer than through the polygon.
    assert run_of(way) < 1000


def test_ways_climb_where_they_can(mission):
    """The ground beyond a path may rise more steeply than an aircraft can climb."""
    pose = Pose(4000.0, 4500.0, 260.0, 1.0, 0.0, 0.0)
    air = present(mission, Circle(4000.0, 4500.0, 300.0))
    out = way_out(air, pose)
    assert out[-1].rise_m > 0.8 * math.tan(math.radians(mission.aircraft.max_climb_deg)) * 300
    low = Rules(ceiling_m=265.0)
    below = Problem(mission.terrain, mission.start, mission.goal, mission.aircraft, rules=low)
    level = way_out(present(below, Circle(4000.0, 4500.0, 300.0)), pose)
    assert level[-1].rise_m == 0
    assert run_of(level) == run_of(out)
    on = way_on(present(mission), pose)
    assert on[-1].rise_m > 0.8 * math.tan(math.radians(mission.aircraft.max_climb_deg)) * 900


def test_a_circle_is_entered_as_late_as_possible_and_is_safe(mission, straight):
    track = Evaluator(mission, threads=1).track(straight).pieces
    air = present(mission, Circle(4000.0, 4500.0, 200.0))
    last = air.safe_until_m(track, 0.0)
    holding = holding_on(air, track, 300.0, last)
    assert 300 <= holding.along_m <= last
    assert holding.is_safe(air)
    assert run_of(holding.circle) == pytest.approx(2 * math.pi * 1.1 * air.turn_radius_m)
    whole = holding.track(part(track, 0.0, holding.along_m), 2)
    # It is flown without a corner, and ends where a circle began.
    for before, after in itertools.pairwise(whole):
        assert end_of(before).point == pytest.approx(after.start, abs=1e-6)
        heading = end_of(before).east, end_of(before).north
        assert heading == pytest.approx(after.heading, abs=1e-9)
    assert end_of(whole[-1]).point == pytest.approx(end_of(whole[-5]).point, abs=1e-6)
    assert holding_on(air, track, 500.0, 400.0) is None


def test_circles_near_the_edge_keep_the_corridor_on_the_map(mission):
    """The track follows the south edge, 60 m from it: only circles to the left fit."""
    air = present(mission)
    track = (Pose(3000.0, 60.0, 290.0, 1.0, 0.0, 0.0).straight(1500.0),)
    holding = holding_on(air, track, 0.0, 1500.0)
    assert holding.is_safe(air)
    for piece in (*holding.way, *holding.circle):
        assert piece.points(np.linspace(0, 1, 500))[:, 1].min() >= 25
    beside = (Pose(3000.0, 20.0, 290.0, 1.0, 0.0, 0.0).straight(1500.0),)
    assert not air.is_safe(beside)
    # An aircraft that is nearer to the edge than the corridor continues with half the corridor.
    on = way_on(air, Pose(3000.0, 20.0, 290.0, 1.0, 0.0, 0.0))
    assert air.off_limits_m(on, 0.5) == 0
    assert way_on(air, Pose(3000.0, 2.0, 290.0, 0.0, 1.0, 0.0))[-1].run_m > 800


@pytest.fixture
def gorge(mission):
    """Function that returns a mission through a gorge; height of its walls, half its width."""

    def through(walls_m, half_m=240.0, cell_m=30.0):
        rows = np.arange(round(9000 / cell_m) + 1) * cell_m
        heights = np.where(np.abs(rows - 4500)[:, None] > half_m, walls_m, 100.0)
        return Problem(
            Terrain("gorge", np.tile(heights, len(rows)), dx_m=cell_m, dy_m=cell_m),
            (1500.0, 4500.0, 150.0),
            (6500.0, 4500.0, 150.0),
            mission.aircraft,
            rules=Rules(),
        )

    return through


def test_in_a_narrow_valley_the_circle_lies_above(gorge):
    """No level circle fits between the walls, but a climbing path rises above them."""
    air = present(gorge(160.0, 120.0, 60.0))
    track = (Pose(1500.0, 4500.0, 150.0, 1.0, 0.0, 0.0).straight(4000.0),)
    holding = holding_on(air, track, 200.0, 2500.0)
    assert holding.is_safe(air)
    assert holding.way
    assert holding.circle[0].start[2] > 185


def test_between_walls_too_high_there_is_none(gorge):
    track = (Pose(1500.0, 4500.0, 150.0, 1.0, 0.0, 0.0).straight(4000.0),)
    assert holding_on(present(gorge(4000.0, 120.0, 60.0)), track, 200.0, 1500.0) is None


def test_a_way_out_never_leads_into_the_ground(gorge):
    """The zone's nearest border is beyond a wall, so the longer route along the gorge is flown."""
    pose = Pose(3000.0, 4500.0, 150.0, 1.0, 0.0, 0.0)
    zone = Polygon([(500, 4300), (3800, 4300), (3800, 4700), (500, 4700)])
    air = present(gorge(400.0), zone)
    way = way_out(air, pose)
    assert end_of(way[-1]).x > 3800
    assert air.off_limits_m(way, 0.1) == 0
    # A zone along the whole gorge is left over its walls, with the clearance that they permit;
    # staying in it is better than flying into walls that are too high.
    whole = Polygon([(-60_000, 4200), (60_000, 4200), (60_000, 4800), (-60_000, 4800)])
    kept = []
    for walls_m in range(150, 900, 10):
        air = present(gorge(float(walls_m)), whole)
        way = way_out(air, pose)
        shares = (1.0, 0.5, 0.1)
        kept.append(0 if way is None else next(s for s in shares if not air.off_limits_m(way, s)))
    assert kept == sorted(kept, reverse=True)
    assert {1.0, 0.5, 0.1, 0} == set(kept)


def test_a_way_on_keeps_from_the_ground_first_and_then_from_zones(gorge):
    pose = Pose(3000.0, 4500.0, 150.0, 1.0, 0.0, 0.0)
    air = present(gorge(400.0))
    assert air.is_safe(way_on(air, pose))
    ahead = present(gorge(400.0), Circle(3300.0, 4500.0, 250.0))
    way = way_on(ahead, pose)
    assert ahead.off_limits_m(way) == 0
    assert ahead.in_zones_m(way) > 0
    cliff = Pose(3000.0, 4735.0, 150.0, 0.0, 1.0, 0.0)
    # Into the rock as steeply as it can climb, and along the wall as far as it can turn.
    way = way_on(air, cliff)
    assert end_of(way[-1]).z > 150 + 0.8 * air.climb(cliff) * run_of(way)
    straight = air.off_limits_m((cliff.straight(run_of(way), air.climb(cliff)),), 0.0)
    assert air.off_limits_m(way, 0.0) < straight
