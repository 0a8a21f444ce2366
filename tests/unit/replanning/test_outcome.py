"""Distances from zones, compared with Shapely, and routes out that are too long."""

import dataclasses

import numpy as np
import pytest
import shapely

from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.replanning.outcome import judge
from pathgene.host.replanning.scenario import Event, NewZone, Placed, Scenario
from pathgene.host.replanning.session import Session


def signed(shape, x, y):
    """Return Shapely's distances from the border of a shape, negative inside."""
    points = shapely.points(x, y)
    distance = shapely.distance(shapely.boundary(shape), points)
    return np.where(shapely.contains(shape, points), -distance, distance)


def test_distances_from_zones_are_those_of_shapely():
    rng = np.random.default_rng(3)
    for _ in range(30):
        angles = np.sort(rng.uniform(0, 2 * np.pi, 9))
        radii = rng.uniform(200, 900, 9)
        ring = np.column_stack((radii * np.cos(angles), radii * np.sin(angles)))
        hole = 0.2 * ring
        x, y = rng.uniform(-1200, 1200, (2, 300))
        zone = Polygon(list(map(tuple, ring)), (list(map(tuple, hole)),))
        shape = shapely.Polygon(ring, [hole])
        if shape.is_valid:
            assert zone.footprint.distance_m(x, y) == pytest.approx(signed(shape, x, y), abs=1e-6)
    x, y = rng.uniform(-900, 900, (2, 300))
    circle = Circle(0.0, 0.0, 400.0).footprint.distance_m(x, y)
    assert circle == pytest.approx(np.hypot(x, y) - 400)


def test_a_way_out_that_is_too_long_is_seen(mission, straight, on_chip):
    covering = Scenario((Event(60.0, (NewZone(Placed("aircraft", 350.0)),)),))
    session = Session(mission, straight, on_chip, covering)
    session.run()
    assert judge(session).alive
    (change,) = session.changes
    # As if there had been a shorter route.
    session.changes[0] = dataclasses.replace(change, inside_m=0.5 * change.inside_m)
    outcome = judge(session)
    assert not outcome.alive
    assert "is left after" in outcome.breaks[0]
