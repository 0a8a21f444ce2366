"""Outlines and margins of zones in the plan view."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.report import zone_shapes


SQUARE = ((0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 9.0))
HOLE = ((3.0, 3.0), (6.0, 3.0), (6.0, 6.0), (3.0, 6.0))
NOTCHED = ((0.0, 0.0), (900.0, 0.0), (900.0, 900.0), (450.0, 300.0), (0.0, 900.0))


def twice_the_area(ring):
    x, y = np.array(ring).T
    return np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


@pytest.mark.parametrize("turn", [1, -1])
def test_holes_run_against_their_ring(turn):
    outline = zone_shapes.outline(Polygon(SQUARE[::turn], (HOLE,)), 1.0).get_path()
    outer, inner = outline.vertices[:4], outline.vertices[5:9]
    assert twice_the_area(outer) > 0 > twice_the_area(inner)


def margin_lines(zone, margin_m, unit_m):
    """Return the lines in metres."""
    figure = Figure()
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(-1, 2), ylim=(-1, 2))
    zone_shapes.draw_margin(axes, zone, margin_m, unit_m)
    assert (axes.get_xlim(), axes.get_ylim()) == ((-1, 2), (-1, 2))
    if axes.patches:
        (patch,) = axes.patches
        return [patch.get_patch_transform().transform_path(patch.get_path()).vertices * unit_m]
    (contour,) = axes.collections
    (path,) = contour.get_paths()
    return [line * unit_m for line in path.to_polygons(closed_only=False)]


def distance_m(ring, points):
    """Distance of points (k, 2) from the edges of a ring."""
    nearest = np.full(len(points), np.inf)
    for first, second in zip(ring, (*ring[1:], ring[0]), strict=True):
        step = np.array(second) - first
        part = np.clip((points - first) @ step / (step @ step), 0, 1)
        off = points - first - part[:, None] * step
        nearest = np.minimum(nearest, np.hypot(*off.T))
    return nearest


@pytest.mark.parametrize("margin_m", [5.0, 25.0, 150.0])
def test_the_margin_of_a_polygon_is_everywhere_as_far_from_it(margin_m):
    (line,) = margin_lines(Polygon(NOTCHED), margin_m, 1000.0)
    # Within one node of the drawn grid, less than two pixels.
    assert distance_m(NOTCHED, line) == pytest.approx(margin_m, abs=1.5)
    assert not Polygon(NOTCHED).covers(line[:, 0], line[:, 1]).diagonal().any()
    # All around, beyond every side.
    assert line.min(axis=0) == pytest.approx(-margin_m, abs=1.5)
    assert line.max(axis=0) == pytest.approx(900 + margin_m, abs=1.5)


def test_a_hole_that_is_wider_than_two_margins_has_its_own_line():
    outer = tuple((100 * x, 100 * y) for x, y in SQUARE)
    hole = tuple((100 * x, 100 * y) for x, y in HOLE)
    zone = Polygon(outer, (hole,))
    lines = margin_lines(zone, 50.0, 1.0)
    assert sorted(np.ptp(line[:, 0]) for line in lines) == pytest.approx([200, 1000], abs=2)
    assert len(margin_lines(zone, 160.0, 1.0)) == 1


def test_the_margin_of_a_circle():
    (line,) = margin_lines(Circle(500.0, 400.0, 200.0), 25.0, 1000.0)
    assert np.ptp(line, axis=0) == pytest.approx(450, rel=0.01)


def test_many_zones_are_one_patch():
    zones = [Circle(100.0 * i, 0.0, 30.0) for i in range(50)] + [Polygon(SQUARE, (HOLE,))]
    extents = zone_shapes.outline_of_all(zones, 10.0).get_path().get_extents()
    np.testing.assert_allclose(extents.get_points(), [[-3, -3], [493, 3]], atol=1e-6)


@pytest.mark.ci
def test_many_zones_look_as_each_alone():
    rng = np.random.default_rng(1)
    zones = [Circle(*rng.uniform(0, 900, 2), rng.uniform(5, 80)) for _ in range(40)]
    zones += [Polygon(tuple((100 * x, 100 * y) for x, y in SQUARE), (tuple(HOLE),))]
    points = rng.uniform(0, 90, (3000, 2))
    together = zone_shapes.outline_of_all(zones, 10.0).get_path().contains_points(points)
    x, y = 10 * points.T
    alone = np.array([zone.covers(x, y).diagonal() for zone in zones]).any(axis=0)
    # A circle is drawn as eight curves, so a point on its border may differ.
    assert np.mean(together != alone) < 0.002


def test_zones_that_a_track_crosses():
    """They are exactly the zones with a point inside, in order, for any number of points."""
    rng = np.random.default_rng(2)
    zones = [Circle(*rng.uniform(0, 900, 2), rng.uniform(1, 60)) for _ in range(300)]
    zones[50:50] = [Polygon(SQUARE, (HOLE,)), Polygon(NOTCHED), Polygon(((5, 5), (6, 5), (5, 6)))]
    for count in (1, 127, 128, 129, 1000):
        along = np.linspace(0, 900, count)
        x, y = along, 450 + 300 * np.sin(along / 90)
        found = list(zone_shapes.crossed(zones, x, y))
        inside = [zone.covers(x, y).diagonal() for zone in zones]
        expected = [zone for zone, held in zip(zones, inside, strict=True) if held.any()]
        assert [id(zone) for zone, _ in found] == [id(zone) for zone in expected]
        for (_, got), held in zip(found, [held for held in inside if held.any()], strict=True):
            np.testing.assert_array_equal(got, held)
    assert list(zone_shapes.crossed([], x, y)) == []
