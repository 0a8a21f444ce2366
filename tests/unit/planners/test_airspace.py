"""The airspace."""

from types import SimpleNamespace

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.planners.airspace import Airspace


def test_box_reaches_over_ground_start_and_goal(make_evaluator):
    space = Airspace(make_evaluator().problem)
    assert space.low.tolist() == [0, 0, 100]
    assert space.high.tolist() == [6000, 4000, 700]
    space = Airspace(make_evaluator(start=(500, 500, 1500), goal=(5500, 700, 1500)).problem)
    assert space.high.tolist() == [6000, 4000, 1500]


@pytest.mark.parametrize(
    ("point", "free"),
    [
        ((1000, 1000, 100), True),  # On the ground.
        ((1000, 1000, 99.9), False),
        ((1000, 1000, 700), True),
        ((1000, 1000, 700.1), False),
        ((-0.1, 1000, 500), False),
        ((3000, 1000, 599), False),  # In the wall.
        ((3000, 1000, 600), True),
        ((4500, 1800, 690), False),  # In the no-fly zone, at any height.
        ((4500, 2160, 300), True),
    ],
)
def test_is_free(evaluator, point, free):
    assert Airspace(evaluator.problem).is_free(np.array([point]))[0] == free


def test_voids_are_not_free(make_evaluator):
    elevation = np.full((41, 61), 100.0)
    elevation[20, 20] = np.nan
    space = Airspace(make_evaluator(elevation).problem)
    assert not space.is_free(np.array([[2000.0, 2000, 190]]))[0]
    assert space.is_free(np.array([[2000.0, 2100, 190]]))[0]


def test_draws_are_free_and_everywhere(evaluator):
    space = Airspace(evaluator.problem)
    points = space.draw(np.random.default_rng(0), 20_000)
    assert space.is_free(points).all()
    wall = (points[:, 0] > 2750) & (points[:, 0] < 3250) & (points[:, 1] < 2950)
    free = np.isfinite(space.floor).sum()
    assert wall.mean() == pytest.approx(30 * 5 / free, abs=0.01)
    # Over flat ground the height is uniform from 100 to 700 m.
    assert points[~wall, 2].mean() == pytest.approx(400, abs=8)


def test_draws_near_a_point_stay_in_its_box(evaluator):
    space = Airspace(evaluator.problem)
    rng = np.random.default_rng(1)
    at = np.array([2500.0, 100, 300])
    points = np.array([space.draw_near(rng, at, 0.15, 8) for _ in range(300)])
    half = 0.075 * np.array([6000, 4000, 600])
    assert (np.abs(points - at) <= half).all()
    assert np.abs(points - at).max(axis=0) == pytest.approx(half, rel=0.1)
    assert space.is_free(points).all()


def test_nothing_free_near_a_point_in_a_wall(make_evaluator):
    elevation = np.full((41, 61), 100.0)
    elevation[:, 10:] = np.nan
    elevation[5, 57] = 100.0
    elevation[5:8, 5:9] = 100.0
    space = Airspace(make_evaluator(elevation, zones=(), goal=(5700, 500, 150)).problem)
    assert space.draw_near(np.random.default_rng(0), np.array([3000.0, 2000, 150]), 0.1, 8) is None


def test_refuses_a_map_without_free_ground(make_evaluator):
    problem = make_evaluator(zones=()).problem
    # A problem refuses zones around its ends, so the test replaces its raster.
    everywhere = SimpleNamespace(
        terrain=problem.terrain,
        start=problem.start,
        goal=problem.goal,
        surface=problem.terrain,
        roof=None,
        limits=problem.limits,
        blocked_raster=np.ones((41, 61), dtype=bool),
    )
    with pytest.raises(
        InputError,
        match=r"^No flyable cell: reduce the no-fly zones or fill the voids \(--fill-voids\)\.$",
    ):
        Airspace(everywhere)
