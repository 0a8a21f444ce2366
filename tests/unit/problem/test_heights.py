"""Limits of height in metres of a terrain, compared with the ground and the standard atmosphere."""

import random

import numpy as np
import pytest
import shapely
from shapely.geometry import Polygon as Shape

from pathgene.host.formats.features import Feature, Limit, Reference
from pathgene.host.problem.heights import Heights
from pathgene.host.problem.placing import Placed
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.surface import surface_below


NODES = 41


def hills(seed, height=800.0):
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(NODES), np.arange(NODES))
    waves = sum(
        rng.uniform(0, 1) * np.sin(rng.uniform(0.05, 0.4) * x + rng.uniform(0.05, 0.4) * y + phase)
        for phase in rng.uniform(0, 6, 5)
    )
    return Terrain("hills", height * (waves - waves.min()) / np.ptp(waves), 100.0, 100.0)


def feature(lower=None, upper=None):
    return Feature(1, "R-1", (((0.0, 0.0),) * 3,), lower=lower, upper=upper)


def bands(terrain, part, lower=None, upper=None, **options):
    return Heights(terrain, **options).bands(feature(lower, upper), part)


def zone_part(rng):
    """Return a circle or a polygon that may reach beyond the map, and its shape."""
    x, y, size = rng.uniform(0, 4000), rng.uniform(0, 4000), rng.uniform(100, 3000)
    if rng.random() < 0.4:
        return Placed((((x, y),),), size), shapely.Point(x, y).buffer(size, quad_segs=64)
    angles = [2 * np.pi * (k + rng.uniform(0, 0.9)) / 7 for k in range(7)]
    ring = tuple((x + size * np.cos(a), y + size * np.sin(a)) for a in angles)
    hole = tuple((x + (e - x) / 3, y + (n - y) / 3) for e, n in ring)
    return Placed((ring, hole)), Shape(ring, [hole])


@pytest.mark.parametrize("seed", range(12))
def test_a_limit_above_the_ground_is_never_on_the_wrong_side(seed):
    rng = random.Random(seed)
    terrain = hills(seed)
    part, shape = zone_part(rng)
    found = bands(terrain, part, Limit(50, Reference.AGL), Limit(120, Reference.AGL))
    assert len(found) > 4
    x, y = np.array([(rng.uniform(0, 4000), rng.uniform(0, 4000)) for _ in range(600)]).T
    inside = shapely.contains_xy(shape, x, y)
    surface = surface_below(terrain, x, y)
    lowest, highest = np.full(600, np.inf), np.full(600, -np.inf)
    for band in found:
        outer, *holes = band.part.rings
        area = shapely.make_valid(Shape(outer))
        for hole in holes:
            area = area.difference(shapely.make_valid(Shape(hole)))
        own = shapely.dwithin(area, shapely.points(x, y), 1e-6)
        lowest[own] = np.minimum(lowest[own], band.lower_m)
        highest[own] = np.maximum(highest[own], band.upper_m)
    assert (lowest[inside] <= surface[inside] + 50 + 1e-9).all()
    assert (highest[inside] >= surface[inside] + 120 - 1e-9).all()
    # The limits follow the ground, on average much more closely than a single figure would.
    if inside.any():
        one = surface[inside].max() - surface[inside]
        followed = highest[inside] - 120 - surface[inside]
        assert followed.mean() < 0.5 * one.mean() + 10


def test_level_ground_leaves_a_zone_whole():
    terrain = Terrain("plain", np.full((NODES, NODES), 300.0), 100.0, 100.0)
    part = Placed((((1000.0, 1000.0),),), 500.0)
    (band,) = bands(terrain, part, Limit(0, Reference.AGL), Limit(120, Reference.AGL))
    assert (band.part, band.lower_m, band.upper_m) == (part, None, 420.0)


def test_zones_share_the_tiles():
    terrain = hills(1)
    part = Placed((((2000.0, 2000.0),),), 2000.0)
    counts = [
        len(bands(terrain, part, upper=Limit(120, Reference.AGL), zones=zones))
        for zones in (1, 30, 5000)
    ]
    assert counts[0] > counts[1] > counts[2] == 1


def pressure_hpa(height_m, qnh_hpa=1013.25):
    """Return the pressure at a height above mean sea level, by the definition of ICAO's QNH."""
    below = 288.15 / 0.0065 * (1 - (qnh_hpa / 1013.25) ** (287.05287 * 0.0065 / 9.80665))
    return 1013.25 * (1 - 0.0065 * (height_m + below) / 288.15) ** (9.80665 / 0.0065 / 287.05287)


@pytest.mark.parametrize("qnh", [960.0, 1013.25, 1040.0])
@pytest.mark.parametrize("level", [45, 95, 195])
def test_flight_levels_are_heights_of_one_pressure(qnh, level):
    terrain = hills(2)
    height_m = level * 30.48
    part = Placed((((2000.0, 2000.0),),), 200.0)
    limit = Limit(height_m, Reference.STANDARD)
    (band,) = bands(terrain, part, limit, Limit(2 * height_m, Reference.STANDARD), qnh_hpa=qnh)
    assert pressure_hpa(band.lower_m, qnh) == pytest.approx(pressure_hpa(height_m), rel=2e-4)
    # Without the pressure, the limits are valid for any pressure.
    (wide,) = bands(terrain, part, limit, Limit(2 * height_m, Reference.STANDARD))
    assert wide.lower_m < band.lower_m
    assert wide.upper_m > band.upper_m


def test_heights_above_the_ellipsoid_hold_for_any_geoid():
    terrain = hills(3)
    part = Placed((((2000.0, 2000.0),),), 200.0)
    (band,) = bands(terrain, part, Limit(500, Reference.WGS84), Limit(900, Reference.WGS84))
    # The geoid lies 106 m below the ellipsoid south of India, and 85 m above it in New Guinea.
    assert band.lower_m <= 500 - 85
    assert band.upper_m >= 900 + 106
