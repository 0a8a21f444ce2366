"""Terms of segments and routes compared with SciPy's splines and plain NumPy."""

import itertools
import math

import numpy as np
import pytest
from scipy.interpolate import BSpline

from pathgene.host.auv.field import AuvField, Base, delta, route_terms, whole_angle
from pathgene.host.auv.landscape import height
from pathgene.host.auv.measures import least_angle, seabed, slope
from pathgene.host.auv.plan import evolve
from pathgene.host.errors import InputError
from pathgene.host.planners.routes.field import Graph, Route, Segments


def drawn(seed, segments=30):
    rng = np.random.default_rng(seed)
    counts = rng.integers(4, 11, segments)
    control = rng.uniform(-0.5, 0.5, (segments, 10, 2))
    control[np.arange(10) >= counts[:, None]] = 0
    return control, counts


def plain_terms(landscape, control, samples, in_space):
    """Return equations (4) to (6) of a segment."""
    knots = np.r_[[0] * 3, np.linspace(0, 1, len(control) - 2), [1] * 3]
    x, y = BSpline(knots, control, 3)(np.linspace(0, 1, samples)).T
    step = np.hypot(np.diff(x), np.diff(y))
    rise = np.diff(height(landscape, x, y))
    before, after = control[:-2] - control[1:-1], control[2:] - control[1:-1]
    cosines = (before * after).sum(axis=1) / np.hypot(*before.T) / np.hypot(*after.T)
    return [
        np.hypot(step, rise if in_space else 0).sum(),
        1 - np.arccos(np.clip(cosines, -1, 1)).min() / np.pi,
        np.abs(rise / step).max(),
    ]


@pytest.mark.parametrize("landscape", [1, 2])
@pytest.mark.parametrize("samples", [2, 21, 301])
@pytest.mark.parametrize("in_space", [False, True])
def test_terms_of_segments(landscape, samples, in_space):
    control, counts = drawn(landscape)
    terms = AuvField(landscape, samples=samples, in_space=in_space).measure(control, counts)
    expected = [
        plain_terms(landscape, own[:count], samples, in_space)
        for own, count in zip(control, counts, strict=True)
    ]
    assert terms == pytest.approx(np.array(expected), rel=1e-7)


@pytest.mark.parametrize(
    ("points", "angle_deg"),
    [
        ([(0, 0), (1, 0), (2, 0)], 180),  # Straight on.
        ([(0, 0), (1, 0), (1, 1)], 90),
        ([(0, 0), (1, 0), (0, 0)], 0),  # Back again.
        ([(0, 0), (1, 0), (2, 1), (3, 1)], 135),
        ([(0, 0), (1, 0), (2, 1), (1, 1)], 45),  # The smaller of two.
        ([(0, 0), (1, 0), (1, 0), (2, 0)], 0),  # A repeated point makes the route invalid.
        ([(0, 0), (1, 0)], 180),
    ],
)
def test_least_angle(points, angle_deg):
    control = np.array(points, dtype=float)
    assert math.degrees(least_angle(control, len(control))) == pytest.approx(angle_deg, abs=1e-9)


def test_delta_is_the_weighted_mean():
    assert delta(np.array([1.4, 0.5, 1.1])) == pytest.approx((1.4 + 2 * 0.5 + 4 * 1.1) / 7)
    assert delta(np.ones((5, 3))) == pytest.approx(np.ones(5))


def route_of(*terms, control=None):
    k = len(terms)
    control = np.zeros((k, 10, 2)) if control is None else control
    return Route(np.zeros((k + 1, 2)), Segments(control, np.full(k, 4), np.array(terms)))


def test_terms_of_a_route():
    route = route_of([0.5, 0.1, 2.0], [0.7, 0.4, 1.0])
    assert route_terms(route.segments.terms).tolist() == [1.2, 0.4, 2.0]
    whole, of_sum = (AuvField(1, reading=reading) for reading in ("route", "sum"))
    assert whole.cost(route) == pytest.approx((1.2 + 0.8 + 8) / 7)
    assert of_sum.cost(route) == pytest.approx((0.5 + 0.2 + 8) / 7 + (0.7 + 0.8 + 4) / 7)
    assert whole.worth([route, route]) == pytest.approx(np.full(2, 7 / 10))


def test_whole_angle_has_the_turn_at_a_crossover_point():
    legs = np.zeros((2, 10, 2))
    legs[0, :4] = [(0, 0), (1, 0), (2, 0), (3, 0)]
    legs[1, :4] = [(3, 0), (3, 1), (3, 2), (3, 3)]
    route = Route(
        np.array([(0.0, 0), (3, 0), (3, 3)]),
        Segments(legs, np.array([4, 4]), AuvField(1).measure(legs, np.array([4, 4]))),
    )
    assert route.segments.terms[:, 1].tolist() == [0, 0]
    assert math.degrees(whole_angle(route)) == pytest.approx(90)


def test_readings_choose_different_routes():
    """Two short segments are better as a whole, but each adds a turn and a slope to the sum."""
    terms = np.array([[1.2, 0.6, 2.0], [0.6, 0.5, 1.5], [0.6, 0.5, 1.5]])
    graph = Graph(
        np.zeros((3, 2)),
        np.array([0, 0, 2]),
        np.array([1, 2, 1]),
        Segments(np.zeros((3, 10, 2)), np.full(3, 4), terms),
    )
    chosen = [
        AuvField(1, reading=reading).best_routes(graph)[0].tolist() for reading in ("route", "sum")
    ]
    assert chosen == [[1, 2], [0]]


def test_finer_samples_of_a_route():
    control, counts = drawn(5, segments=3)
    field = AuvField(2, samples=21)
    route = Route(np.zeros((4, 2)), Segments(control, counts, field.measure(control, counts)))
    before = field.evaluations
    fine = field.whole_terms(route, 1001)
    assert fine == pytest.approx(route_terms(AuvField(2, samples=1001).measure(control, counts)))
    assert (field.whole_terms(route) != fine).any()
    assert field.evaluations == before == 3  # Evaluations of the search only.


def steepest(landscape, control, number=100_001):
    """Return the maximum slope of the seabed along a segment at many points."""
    knots = np.r_[[0] * 3, np.linspace(0, 1, len(control) - 2), [1] * 3]
    x, y = BSpline(knots, control, 3)(np.linspace(0, 1, number)).T
    steps = np.hypot(np.diff(x), np.diff(y))
    return (np.abs(np.diff(height(landscape, x, y))) / steps).max()


@pytest.mark.parametrize("landscape", [1, 2])
def test_default_samples_see_the_steepest_place(landscape):
    control, counts = drawn(landscape + 10, segments=60)
    rates = AuvField(landscape).measure(control, counts)[:, 2]
    true = [steepest(landscape, own[:n]) for own, n in zip(control, counts, strict=True)]
    assert rates == pytest.approx(np.array(true), rel=0.01)


def test_default_samples_do_not_step_over_a_hill():
    """With seed 1, 21 samples call the path flat, because it bunches them in the valleys."""
    paper = AuvField(1, samples=21)
    for generation in itertools.islice(evolve(paper, "ga-dp", seed=1), 100):
        route = generation.best
    # As measured by version 0.1.
    assert delta(paper.whole_terms(route)) == pytest.approx(0.5995068116602426, rel=1e-9)
    assert delta(paper.whole_terms(route, 1001)) == pytest.approx(6.919479577525211, rel=1e-9)
    segments = route.segments
    honest = route_terms(AuvField(1).measure(segments.control, segments.counts))
    assert delta(honest) == pytest.approx(delta(paper.whole_terms(route, 1001)), rel=0.01)


def test_default_samples_see_the_slope_of_a_hairpin():
    """The hairpin leads along the contour, turns up the slope within half a step, and back."""
    x, y = 0.28, 0.05  # On a slope whose contour runs nearly along x.
    control = np.zeros((1, 10, 2))
    control[0, :7] = [
        (x - 0.2, y), (x - 0.1, y), (x, y), (x + 0.001, y + 0.0005), (x, y + 0.001),
        (x - 0.1, y + 0.001), (x - 0.2, y + 0.001),
    ]  # fmt: skip
    counts = np.array([7])
    rate = AuvField(2).measure(control, counts)[0, 2]
    assert rate == pytest.approx(steepest(2, control[0, :7], 1_000_001), rel=0.01)


@pytest.mark.parametrize("landscape", [1, 2])
def test_slope_is_the_derivative_of_the_height(landscape):
    bed = seabed(landscape)
    step = 1e-6
    for x, y, angle in np.random.default_rng(0).uniform(-0.5, 0.5, (100, 3)) * (1, 1, 6.28):
        dx, dy = step * math.cos(angle), step * math.sin(angle)
        rise = height(landscape, x + dx, y + dy) - height(landscape, x - dx, y - dy)
        assert slope(bed, x, y, dx / step, dy / step) == pytest.approx(
            abs(rise) / (2 * step), abs=1e-6
        )
    assert math.isfinite(slope(bed, 0.0, 0.0, 1.0, 0.0))


def test_base_is_a_square():
    base = Base()
    points = base.draw(np.random.default_rng(0), 4000)
    assert base.is_free(points).all()
    assert np.abs(np.ptp(points, axis=0) - 1).max() < 0.01
    assert base.is_free(np.array([(0.5, -0.5), (0.51, 0), (0, -0.51)])).tolist() == [
        True,
        False,
        False,
    ]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"reading": "both"}, "The reading must be one of route, sum, not 'both'."),
        ({"samples": 1}, "The samples of a segment must be from 2 to 100001, not 1."),
        ({"landscape": 0}, "The landscape must be one of 1, 2, not 0."),
    ],
)
def test_refuses_options_out_of_range(options, sentence):
    with pytest.raises(InputError) as caught:
        AuvField(**{"landscape": 1, **options})
    assert str(caught.value) == sentence
