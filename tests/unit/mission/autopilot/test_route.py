"""Waypoints of an autopilot: close to the track, flown with the given acceptance radii."""

import itertools
import math

import numpy as np
import pytest

from pathgene.host.evaluation.geometry import smooth
from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.mission.autopilot.route import MOST_ACCEPTANCE_M, leg_tolerance_m, route
from pathgene.host.terrain import Terrain


GROUND = Terrain("plain", np.zeros((101, 101)), 50.0, 50.0)
# Maximum lateral acceleration that an autopilot commands.
SPEED_M_S, TURN_RADIUS_M = 23.0, 150.0  # The Silver Fox's.


def track_of(path, radius_m=TURN_RADIUS_M, goal_heading=None):
    smoothed = smooth(np.asarray(path, float), radius_m, (None, goal_heading))
    return SmoothedTrack(smoothed.pieces, GROUND)


def random_track(seed, radius_m):
    """Return a track whose arcs fit: legs to the east of some radii, turns of up to 140 degrees."""
    rng = np.random.default_rng(seed)
    x, y, z, heading = 2500.0, 2500.0, 200.0, 0.0
    path = [(x, y, z)]
    for _ in range(8):
        length = radius_m * rng.uniform(6, 9)
        x, y = x + length * math.cos(heading), y + length * math.sin(heading)
        z += length * rng.uniform(-0.1, 0.1)
        path.append((x, y, z))
        heading = math.radians(rng.uniform(-70, 70))
    return track_of(path, radius_m)


def columns(points):
    return np.array([(point.x_m, point.y_m, point.z_m) for point in points])


def nearest_on_legs(points, legs):
    """Return distance from the legs and height above them of points (n, 3)."""
    best = np.full(len(points), np.inf)
    height = np.zeros(len(points))
    for a, b in itertools.pairwise(legs):
        d = b - a
        square = d[:2] @ d[:2]
        along = np.clip((points[:, :2] - a[:2]) @ d[:2] / square, 0, 1) if square else 0.0
        foot = a + np.multiply.outer(along, d) if square else np.tile(a, (len(points), 1))
        distance = np.hypot(*(points - foot)[:, :2].T)
        nearer = distance < best
        best[nearer] = distance[nearer]
        height[nearer] = (points - foot)[nearer, 2]
    return best, height


@pytest.mark.parametrize("radius_m", [40.0, 150.0, 900.0])
@pytest.mark.parametrize("tolerance_m", [0.25, 2.0])
def test_the_legs_follow_the_track(radius_m, tolerance_m):
    for seed in range(10):
        track = random_track(seed, radius_m)
        samples = track.sample(radius_m / 100)
        points = np.column_stack((samples.x, samples.y, samples.z))
        aside, above = nearest_on_legs(points, columns(route(track, tolerance_m)))
        assert aside.max() <= tolerance_m + 1e-9, seed
        # The slope along a leg and along its arc differ by a few per cent.
        assert np.abs(above).max() < 0.05 * tolerance_m + 0.3, seed


def test_starts_and_ends_where_the_path_does():
    path = [(0.0, 0.0, 100.0), (2000.0, 500.0, 150.0), (2500.0, 4000.0, 120.0)]
    points = route(track_of(path), 2.0)
    assert tuple(columns(points)[0]) == path[0]
    assert tuple(columns(points)[-1]) == path[-1]


def test_has_the_tangent_points_of_an_arc():
    track = track_of([(0, 0, 100), (2000, 0, 100), (2000, 2000, 100)])
    (arc,) = track.pieces[1:-1]
    points = columns(route(track, 2.0))
    for tangent in (arc.start, arc.points(np.array([1.0]))[0]):
        assert np.abs(points - tangent).sum(axis=1).min() < 1e-6


def test_two_arcs_share_the_waypoint_between_them():
    track = track_of([(0, 0, 100), (1000, 0, 100), (1000, 300, 100), (2000, 300, 100)])
    points = columns(route(track, 2.0))
    assert np.hypot(*np.diff(points, axis=0)[:, :2].T).min() > 1
    assert (np.abs(points - (1000, 150, 100)).sum(axis=1) < 1e-6).sum() == 1


@pytest.mark.parametrize("turn_rad", [0.01, 0.5 * math.pi])
def test_ends_where_the_turn_to_the_heading_at_the_goal_ends(turn_rad):
    """The smaller turn is too short for waypoints where its arc begins and ends."""
    heading = (math.cos(turn_rad), math.sin(turn_rad))
    track = track_of([(0, 0, 100), (2000, 0, 100)], goal_heading=heading)
    beyond_m = TURN_RADIUS_M * math.tan(0.5 * turn_rad)
    end = (2000 + beyond_m * heading[0], beyond_m * heading[1], 100)
    assert np.allclose(columns(route(track, 2.0))[-1], end, atol=1e-6, rtol=0)


def test_the_track_keeps_every_acceptance_radius():
    """An autopilot on the track comes within the radius, and first where the leg meets the arc."""
    for seed in range(20):
        track = random_track(seed, 70.0)
        samples = track.sample(0.5)
        points = route(track, 2.0)
        for point in points:
            distance = np.hypot(samples.x - point.x_m, samples.y - point.y_m)
            assert distance.min() < point.acceptance_m
        for first, second in itertools.pairwise(points):
            apart = math.dist((first.x_m, first.y_m), (second.x_m, second.y_m))
            for point in (first, second):
                assert point.acceptance_m == 1 or point.acceptance_m < apart
                assert isinstance(point.acceptance_m, int)
                assert 1 <= point.acceptance_m <= MOST_ACCEPTANCE_M


def flown(points, lateral_m_s2, reach_m):
    """Fly to each waypoint within its radius, then turn to the next: positions (n, 2).

    The guidance is L1 on the current leg, as in ArduPlane and PX4, at constant speed.
    """
    step_s = 0.05
    places = columns(points)[:, :2]
    position = places[0].copy()
    heading = math.atan2(*(places[1] - places[0])[::-1])
    way = []
    for before, aim, point in zip(places, places[1:], points[1:], strict=False):
        leg = (aim - before) / np.hypot(*(aim - before))
        for _ in range(100_000):
            left = aim - position
            if np.hypot(*left) <= point.acceptance_m or left @ leg <= 0:
                break
            foot = before + max((position - before) @ leg, 0.0) * leg
            off = np.hypot(*(position - foot))
            ahead = foot + leg * math.sqrt(max(reach_m**2 - off**2, 1.0)) - position
            error = math.atan2(ahead[1], ahead[0]) - heading
            sideways = 2 * SPEED_M_S**2 / reach_m * math.sin(error)
            sideways = min(max(sideways, -lateral_m_s2), lateral_m_s2)
            heading += sideways / SPEED_M_S * step_s
            position = position + SPEED_M_S * step_s * np.array(
                (math.cos(heading), math.sin(heading))
            )
            way.append(position)
    return np.array(way)


@pytest.mark.ci
@pytest.mark.parametrize("strength", [1.05, 1.5])
@pytest.mark.parametrize(("reach_m", "limit_m"), [(40.0, 6.0), (90.0, 25.0)])
def test_an_autopilot_that_turns_at_the_waypoint_stays_in_the_corridor(strength, reach_m, limit_m):
    """The autopilot's sharpest turn is slightly, or much, sharper than the planned one.

    It looks 40 m ahead, or 90 m, as ArduPlane does by default at this speed.
    """
    worst = 0.0
    for seed in range(3):
        track = random_track(seed, TURN_RADIUS_M)
        way = flown(route(track, 2.0), strength * SPEED_M_S**2 / TURN_RADIUS_M, reach_m)
        samples = track.sample(1.0)
        line = np.column_stack((samples.x, samples.y))
        apart = np.min(np.hypot(*(way[::5, None, :] - line[None, ::2, :]).transpose(2, 0, 1)), 1)
        worst = max(worst, float(apart.max()))
    assert worst < limit_m


def test_a_corner_without_arc_is_one_waypoint():
    track = track_of([(0, 0, 100), (100, 0, 100), (0, 10, 100)])  # Too sharp for an arc.
    points = route(track, 2.0)
    assert columns(points).tolist() == [[0, 0, 100], [100, 0, 100], [0, 10, 100]]


def test_a_slight_turn_is_one_waypoint():
    track = track_of([(0, 0, 100), (2000, 0, 110), (4000, 20, 120)])
    assert np.allclose(columns(route(track, 2.0)), [(0, 0, 100), (2000, 0, 110), (4000, 20, 120)])


@pytest.mark.parametrize(
    ("corridor_m", "tolerance_m"), [(None, 2.0), (25.0, 2.0), (4.0, 1.0), (0.0, 0.25)]
)
def test_the_legs_take_a_quarter_of_a_narrow_corridor(corridor_m, tolerance_m):
    assert leg_tolerance_m(corridor_m) == tolerance_m
