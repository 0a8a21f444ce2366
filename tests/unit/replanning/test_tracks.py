"""Places on tracks and parts of them, compared with dense points of the pieces."""

import dataclasses
import math

import numpy as np
import pytest

from pathgene.host.evaluation.geometry import smooth
from pathgene.host.replanning.tracks import Pose, end_of, is_smooth, part, pose_at, run_of


PATH = np.array([(0, 0, 100), (900, 100, 160), (1500, 900, 120), (1500, 2200, 200)], dtype=float)
TRACK = smooth(PATH, 150.0).pieces


def dense(pieces, count=400):
    """Return points along pieces, and the horizontal distance of each."""
    points, along, passed = [], [], 0.0
    for piece in pieces:
        fractions = np.linspace(0, 1, count)
        points.append(piece.points(fractions))
        along.append(passed + fractions * piece.run_m)
        passed += piece.run_m
    return np.concatenate(points), np.concatenate(along)


def test_a_pose_is_on_the_track_and_heads_along_it():
    points, along = dense(TRACK)
    for at in np.linspace(1, run_of(TRACK) - 1, 57):
        pose = pose_at(TRACK, at)
        expected = [np.interp(at, along, points[:, axis]) for axis in range(3)]
        assert pose.point == pytest.approx(expected, abs=0.02)
        ahead = pose_at(TRACK, at + 0.01)
        assert ahead.x - pose.x == pytest.approx(0.01 * pose.east, abs=1e-5)
        assert ahead.y - pose.y == pytest.approx(0.01 * pose.north, abs=1e-5)
        assert ahead.z - pose.z == pytest.approx(0.01 * pose.slope, abs=2e-3)
        assert math.hypot(pose.east, pose.north) == pytest.approx(1)
        turned = math.radians(pose.heading_deg)
        assert (math.sin(turned), math.cos(turned)) == pytest.approx((pose.east, pose.north))


def test_beyond_its_ends_a_track_has_the_poses_of_its_ends():
    assert pose_at(TRACK, -5) == pose_at(TRACK, 0)
    assert pose_at(TRACK, 1e6) == end_of(TRACK[-1])
    with pytest.raises(ValueError, match="horizontal length"):
        pose_at((), 0)


@pytest.mark.parametrize(("first", "last"), [(0, 400), (700, 900), (850, 2600), (-50, math.inf)])
def test_a_part_is_the_track_between_two_distances(first, last):
    parts = part(TRACK, first, last)
    begin, end = max(first, 0.0), min(last, run_of(TRACK))
    assert run_of(parts) == pytest.approx(end - begin)
    for at in np.linspace(0, end - begin, 23):
        assert pose_at(parts, at).point == pytest.approx(pose_at(TRACK, begin + at).point)
        assert pose_at(parts, at).heading_deg == pytest.approx(
            pose_at(TRACK, begin + at).heading_deg
        )
    assert part(TRACK, run_of(TRACK) + 1) == ()
    assert part(TRACK, 500, 400) == ()


def test_turns_and_straights_follow_a_pose():
    pose = Pose(10.0, 20.0, 30.0, 0.0, 1.0, 0.1)
    assert end_of(pose.straight(50.0, 0.2)).point == pytest.approx((10, 70, 40))
    left = end_of(pose.arc(100.0, math.pi / 2, 0.1))
    assert left.point == pytest.approx((-90, 120, 30 + 5 * math.pi))
    assert (left.east, left.north) == pytest.approx((-1, 0))
    right = end_of(pose.arc(100.0, -math.pi / 2))
    assert right.point == pytest.approx((110, 120, 30))


def test_a_track_is_smooth_where_each_piece_begins_where_the_one_before_ends():
    pose = Pose(0.0, 0.0, 100.0, 1.0, 0.0, 0.0)
    first = pose.straight(500.0)
    turn = end_of(first).arc(150.0, 1.2)
    last = end_of(turn).straight(300.0, 0.1)
    assert is_smooth((first, turn, last))
    assert is_smooth((first,))
    assert not is_smooth((first, last))
    end = end_of(first)
    aside = dataclasses.replace(end, y=end.y + 2)
    bent = dataclasses.replace(end, east=math.cos(0.1), north=math.sin(0.1))
    assert not is_smooth((first, aside.straight(50.0)))
    assert not is_smooth((first, bent.straight(50.0)))
