"""The smoothed track as points, compared with the closed forms."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem import aircraft
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain


ROUGH = Terrain(
    name="rough",
    elevation=np.random.default_rng(5).uniform(0, 400, (41, 51)),
    dx_m=100.0,
    dy_m=125.0,
    crs=None,
    origin=(0.0, 0.0),
)
PROBLEM = Problem(ROUGH, (0, 0, 400), (5000, 5000, 500), aircraft.load("silver-fox"), as_paper=True)
EVALUATOR = Evaluator(PROBLEM, threads=1)

points = st.lists(
    st.tuples(st.floats(0, 5000), st.floats(0, 5000), st.floats(300, 900)), max_size=6
)


def path(*waypoints):
    return np.array([PROBLEM.start, *waypoints, PROBLEM.goal])


def test_samples_of_a_corner():
    track = EVALUATOR.track(path((5000, 0, 450)))
    samples = track.sample(7.0)
    length = 2 * 4850 + 75 * math.pi
    assert track.length_m == pytest.approx(length, rel=1e-3)
    assert samples.s[0] == 0
    assert samples.s[-1] == pytest.approx(track.length_m)
    assert (np.diff(samples.s) > 0).all()
    assert np.diff(samples.s).max() <= 7.0 * (1 + 1e-9)
    steps = np.sqrt(sum(np.diff(axis) ** 2 for axis in (samples.x, samples.y, samples.z)))
    # Chords are slightly shorter than their arcs.
    np.testing.assert_allclose(steps, np.diff(samples.s), rtol=1e-3)
    assert [samples.x[0], samples.y[0], samples.z[0]] == list(PROBLEM.start)
    assert [samples.x[-1], samples.y[-1], samples.z[-1]] == list(PROBLEM.goal)


def test_ground_and_clearance_are_those_of_the_nearest_node():
    samples = EVALUATOR.track(path((4000, 1000, 450))).sample(50.0)
    for x, y, z, ground, clearance in zip(
        samples.x, samples.y, samples.z, samples.ground, samples.clearance, strict=True
    ):
        assert ground == ROUGH.elevation[math.floor(y / 125 + 0.5), math.floor(x / 100 + 0.5)]
        assert clearance == z - ground


@pytest.mark.parametrize("step_m", [3.0, 0.007])
def test_the_least_clearance_is_that_of_all_samples(step_m):
    """A million of them need several blocks."""
    track = EVALUATOR.track(path((4000, 1000, 450), (4500, 3000, 600)))
    assert track.least_clearance_m(step_m) == track.midpoints(step_m)[0].clearance.min()


def test_the_least_clearance_is_not_over_voids():
    heights = ROUGH.elevation.copy()
    heights[:, 10:] = np.nan
    void = Terrain("void", heights, 100.0, 125.0)
    track = dataclasses.replace(EVALUATOR.track(path((4000, 1000, 450))), terrain=void)
    clearance = track.midpoints(5.0)[0].clearance
    assert np.isnan(clearance).any()
    assert track.least_clearance_m(5.0) == np.nanmin(clearance)
    beyond = dataclasses.replace(track, pieces=track.pieces[-1:])
    assert np.isnan(beyond.midpoints(5.0)[0].clearance).all()
    assert math.isnan(beyond.least_clearance_m(5.0))


@pytest.mark.parametrize("step", [0, -1.0, math.nan, math.inf])
def test_refuses_a_bad_step(step):
    with pytest.raises(ValueError, match=r"^Step must be a positive number of metres, not "):
        EVALUATOR.track(path()).sample(step)


@settings(max_examples=40)
@given(points)
def test_closed_forms_are_the_integrals_of_the_track(waypoints):
    terms = EVALUATOR.evaluate(path(*waypoints))
    samples = EVALUATOR.track(path(*waypoints)).sample(5.0)
    steps = np.sqrt(sum(np.diff(axis) ** 2 for axis in (samples.x, samples.y, samples.z)))
    assert steps.sum() == pytest.approx(terms.length_m, rel=1e-3)
    mean = ((samples.z[1:] + samples.z[:-1]) / 2 * np.diff(samples.s)).sum() / samples.s[-1]
    assert mean == pytest.approx(terms.mean_altitude_m, rel=1e-9)
    assert samples.clearance.min() == pytest.approx(terms.minimum_clearance_m, abs=60)


@settings(max_examples=40)
@given(points, st.data())
def test_a_waypoint_on_a_straight_segment_changes_little(waypoints, data):
    way = path(*waypoints)
    if (np.hypot(*np.diff(way[:, :2], axis=0).T) < 1.0).any():
        return
    whole = EVALUATOR.evaluate(way)
    segment = data.draw(st.integers(0, len(way) - 2))
    middle = 0.5 * (way[segment] + way[segment + 1])
    split = EVALUATOR.evaluate(np.insert(way, segment + 1, middle, axis=0))
    # Compare only paths whose arcs still fit on half the segment.
    if split.impossible_arcs == whole.impossible_arcs == 0:
        assert split.length_m == pytest.approx(whole.length_m, rel=1e-9)
        assert split.mean_altitude_m == pytest.approx(whole.mean_altitude_m, rel=1e-9)
        assert split.fuel_N == pytest.approx(whole.fuel_N, rel=1e-9)
        assert split.distance_too_steep_m == pytest.approx(whole.distance_too_steep_m, abs=1e-6)


@settings(max_examples=40)
@given(points)
def test_fitness_is_always_inside_its_range(waypoints):
    way = path(*waypoints)
    (fitness,) = EVALUATOR.fitness(way[None], np.array([len(way)]))
    assert 0 < fitness < 2
