"""The altitude profile: clearance, ceilings, zones."""

import numpy as np
import pytest
from matplotlib.text import Text

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.report.picture import Scene, draw
from tests.support.host.pictures import assert_texts_apart


def profile_of(make_run, *, zones=None, aircraft=None, height_m=300.0, **rules):
    """Return the axes of the profile, the evaluator and the path."""
    evaluator, result = make_run(height_m=height_m)
    old = evaluator.problem
    problem = Problem(
        old.terrain,
        old.start,
        old.goal,
        zones=old.zones if zones is None else zones,
        rules=Rules(**rules),
    )
    evaluator = Evaluator(problem, threads=1)
    figure = draw(Scene(evaluator, result.path, evaluator.evaluate(result.path), [], "", ""))
    figure.canvas.draw()
    assert_texts_apart(figure)
    return figure.axes[2], evaluator, result.path


def texts(axes):
    return {text.get_text() for text in axes.findobj(Text)}


def line_of(axes, heights):
    """Return whether a dashed line has these altitudes at the middle of the path."""
    dashed = [line for line in axes.get_lines() if line.get_linestyle() == "--"]
    return any(np.allclose(line.get_ydata(), heights, equal_nan=True) for line in dashed)


def test_profile_names_clearance_ceiling_and_broken_limits_and_marks_the_strict_minimum(make_run):
    profile, evaluator, path = profile_of(make_run, height_m=-400.0, ceiling_m=500.0)
    evaluation = evaluator.evaluate(path)
    assert {"clearance 30 m", "ceiling 500 m", "clearance"} <= texts(profile)
    (marker,) = [line for line in profile.get_lines() if line.get_marker() == "v"]
    x, z = marker.get_xydata()[0]
    at_m = evaluator.lowest_at_m(path)
    assert x == pytest.approx(at_m / 1000)
    samples, _ = evaluator.track(path).midpoints(1.0)
    assert z == pytest.approx(np.interp(at_m, samples.s, samples.z), abs=1.0)
    # The corridor is never lower than the ground below the track.
    below = np.interp(at_m, samples.s, samples.ground)
    assert evaluation.minimum_clearance_m <= z - below + 1.0


@pytest.mark.parametrize(("ceiling_m", "near"), [(1000.0, True), (1100.0, True), (4000.0, False)])
def test_a_ceiling_above_the_path_is_shown_if_near_and_named_if_not(make_run, ceiling_m, near):
    profile, _, path = profile_of(make_run, ceiling_m=ceiling_m)
    assert ceiling_m > path[:, 2].max()
    assert (profile.get_ylim()[1] > ceiling_m) == near
    assert line_of(profile, ceiling_m)
    name = f"ceiling {ceiling_m:,.0f} m"
    assert (name if near else f"\u2191 {name}") in texts(profile)
    # The path still takes more than half of the height.
    low, high = profile.get_ylim()
    assert np.ptp(path[:, 2]) > 0.4 * (high - low)


@pytest.mark.parametrize(("above_m", "near"), [(500.0, True), (9000.0, False)])
def test_a_ceiling_above_ground_follows_the_ground_and_has_its_name(make_run, above_m, near):
    profile, *_ = profile_of(make_run, ceiling_agl_m=above_m)
    (line,) = [line for line in profile.get_lines() if line.get_linestyle() == "--"]
    heights = line.get_ydata()
    ground = profile.get_lines()[0].get_ydata()
    assert heights == pytest.approx(ground + above_m)
    assert np.ptp(heights) > 100
    name = f"ceiling {above_m:,.0f} m above ground"
    assert (name if near else f"\u2191 {name}") in texts(profile)


def test_two_ceilings_have_two_names(make_run):
    profile, *_ = profile_of(make_run, ceiling_m=5000.0, ceiling_agl_m=3000.0)
    assert {"\u2191 ceiling 5,000 m", "\u2191 ceiling 3,000 m above ground"} <= texts(profile)


def test_zones_are_blocks_of_their_heights_where_the_track_crosses_them(make_run):
    """The path goes north-east from (1.8, 0.8) km to (4.8, 2.8) km."""
    zones = (
        Circle(3300.0, 1800.0, 250.0, name="town", lower_m=300.0, upper_m=700.0),
        Polygon(
            ((4000, 1000), (4400, 1000), (4400, 3000), (4000, 3000)),
            (((4150, 2000), (4250, 2000), (4250, 2800), (4150, 2800)),),
            name="field",
        ),
        Circle(1000.0, 3500.0, 250.0, name="aside"),
    )
    profile, evaluator, path = profile_of(make_run, zones=zones)
    samples = evaluator.track(path).sample(1.0)
    parts = blocks(profile)
    # The hole splits the block of the polygon in two.
    assert len(parts) == 3
    for blocked, zone, low, high in (
        (parts[:1], zones[0], 300.0, 700.0),
        (parts[1:], zones[1], *profile.get_ylim()),
    ):
        inside = zone_holds(zone, samples.x, samples.y)
        borders = np.flatnonzero(np.diff(inside.astype(int)))
        for part, (first, last) in zip(blocked, borders.reshape(-1, 2), strict=True):
            at = (part.x0, part.x1)
            assert at == pytest.approx((samples.s[first] / 1000, samples.s[last] / 1000), abs=0.02)
            assert (part.y0, part.y1) == pytest.approx((low, high))


def blocks(profile):
    """Return the boxes of the zones, in the units of the graph."""
    (drawn,) = [patch for patch in profile.collections if patch.get_hatch() == "///"]
    return [outline.get_extents() for outline in drawn.get_paths()]


def test_heights_of_zones_beyond_the_graph(make_run):
    """A block ends near the graph even if its zone is high; a zone outside the graph has none."""
    zones = (
        Circle(3300.0, 1800.0, 250.0, lower_m=-1e308, upper_m=1e308),
        Circle(3300.0, 1800.0, 250.0, upper_m=-5000.0),
        Circle(3300.0, 1800.0, 250.0, lower_m=90_000.0),
    )
    profile, *_ = profile_of(make_run, zones=zones)
    (part,) = blocks(profile)
    bottom, top = profile.get_ylim()
    assert part.y0 <= bottom < top <= part.y1
    assert part.height <= 3.01 * (top - bottom)


def zone_holds(zone, x, y):
    """Return which points are in a zone, by its own rule for single nodes."""
    return np.array(
        [zone.covers(np.array([e]), np.array([n]))[0, 0] for e, n in zip(x, y, strict=True)]
    )
