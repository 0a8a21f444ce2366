"""The sampler of points and segments."""

import numpy as np
import pytest

from pathgene.host.auv.field import Base
from pathgene.host.errors import InputError
from pathgene.host.planners.routes.field import Route, Segments
from pathgene.host.planners.routes.point_sampler import PointSampler, _resized
from pathgene.host.planners.routes.spline import sample


def kept_route(rng, counts=(4, 7, 10)):
    """Return a route whose segments have these numbers of control points."""
    counts = np.array(counts)
    control = rng.uniform(-0.4, 0.4, (len(counts), 10, 2))
    control[1:, 0] = control[np.arange(len(counts) - 1), counts[:-1] - 1]
    control[np.arange(10) >= counts[:, None]] = 0
    points = np.concatenate((control[:, 0], control[-1:, counts[-1] - 1]))
    return Route(points, Segments(control, counts, np.zeros((len(counts), 3))))


@pytest.mark.parametrize("kind", ["near", "uniform"])
def test_segments_connect_their_points(kind):
    rng = np.random.default_rng(0)
    tails, heads = rng.uniform(-0.5, 0.5, (2, 7000, 2))
    control, counts = PointSampler(Base(), kind).segments(rng, tails, heads)
    assert np.abs(np.bincount(counts, minlength=11)[4:] - 1000).max() < 160
    assert np.array_equal(control[:, 0], tails)
    assert np.array_equal(control[np.arange(7000), counts - 1], heads)
    beyond = np.arange(10) >= counts[:, None]
    assert (control[beyond] == 0).all()
    assert np.abs(control).max() <= 0.5
    inner = control[~beyond & (np.arange(10) > 0) & (np.arange(10) < counts[:, None] - 1)]
    if kind == "uniform":
        assert np.abs(np.histogram(inner[:, 0], 10, (-0.5, 0.5))[0] / len(inner) - 0.1).max() < 0.01


def test_near_segments_scale_with_the_line():
    rng = np.random.default_rng(1)
    sampler = PointSampler(Base(), "near")
    off = []
    for reach in (0.01, 0.1):
        tails = np.zeros((4000, 2))
        control, counts = sampler.segments(rng, tails, tails + np.array([reach, 0]))
        inner = (np.arange(10) > 0) & (np.arange(10) < counts[:, None] - 1)
        off.append(np.abs(control[:, :, 1][inner]).mean() / reach)
        along = control[counts == 4][:, 1:3, 0].mean(axis=0) / reach
        assert along == pytest.approx([1 / 3, 2 / 3], abs=0.05)
    assert off[0] == pytest.approx(off[1], rel=0.1)
    assert 0.01 < off[0] < 0.5


def test_draws_first_points_anywhere_and_later_ones_near_the_route():
    rng = np.random.default_rng(2)
    route = kept_route(rng)
    near = PointSampler(Base(), "near")
    curve = sample(route.segments.control, route.segments.counts, 40).reshape(-1, 2)

    def far(points):
        return np.median(np.sqrt(((points[:, None] - curve) ** 2).sum(axis=2)).min(axis=1))

    first = near.points(rng, 4000, None)
    assert far(near.points(rng, 4000, route)) < 0.6 * far(first)
    assert np.abs(first.mean(axis=0)).max() < 0.02
    anywhere = PointSampler(Base(), "uniform").points(rng, 4000, route)
    assert far(anywhere) == pytest.approx(far(first), rel=0.1)


def test_redraws_blocked_points_anywhere():
    class East(Base):
        def is_free(self, points):
            return points[:, 0] > 0

        def draw(self, rng, count):
            return rng.uniform((0, -0.5), (0.5, 0.5), (count, 2))

    rng = np.random.default_rng(3)
    points = PointSampler(East(), "near").points(rng, 2000, kept_route(rng))
    assert (points[:, 0] > 0).all()


def test_variants_keep_ends_and_limits():
    rng = np.random.default_rng(4)
    old = kept_route(rng).segments.take(np.repeat([0, 1, 2], 1000))
    control, counts = PointSampler(Base(), "near").variants(rng, old)
    rows = np.arange(len(old))
    assert np.array_equal(control[:, 0], old.control[:, 0])
    assert np.array_equal(control[rows, counts - 1], old.control[rows, old.counts - 1])
    assert np.abs(control).max() <= 0.5
    assert (control[np.arange(10) >= counts[:, None]] == 0).all()
    # A tenth would have a point more or less if the limits allowed it.
    changed = [np.unique(counts[old.counts == size], return_counts=True) for size in (4, 7, 10)]
    assert [sizes.tolist() for sizes, _ in changed] == [[4, 5], [6, 7, 8], [9, 10]]
    assert changed[1][1][[0, 2]] == pytest.approx([50, 50], abs=28)
    # One control point of some paths moved, all of the rest; never an end.
    same = counts == old.counts
    moved = (control[same] != old.control[same]).any(axis=2).sum(axis=1)
    assert (moved == 1).mean() == pytest.approx(0.5, abs=0.04)
    assert set(moved.tolist()) == {1, 2, 5, 8}


def test_resizing_adds_a_point_halfway_or_removes_one():
    rng = np.random.default_rng(6)
    route = kept_route(rng, (6,) * 400)
    old = route.segments.control
    control, counts = _resized(rng, old, route.segments.counts)
    assert {4, 5, 6, 7} >= set(counts.tolist()) > {6}
    for before, after, count in zip(old, control, counts, strict=True):
        if count == 6:
            assert np.array_equal(before, after)
        if count == 5:
            left_out = [np.delete(before, i, axis=0)[:5] for i in range(1, 5)]
            assert any(np.array_equal(after[:5], each) for each in left_out)
        if count == 7:
            added = [
                np.insert(before, i, (before[i - 1] + before[i]) / 2, axis=0)[:7]
                for i in range(1, 6)
            ]
            assert any(np.array_equal(after[:7], each) for each in added)


def test_refuses_other_draws():
    with pytest.raises(InputError, match=r"^The draws must be one of near, uniform, not 'far'\.$"):
        PointSampler(Base(), "far")
