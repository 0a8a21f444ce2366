"""Winds and headings count from true north, whatever the north of the map's grid."""

import math
from pathlib import Path

import numpy as np
import pyproj
import pytest

from pathgene.host.evaluation import Evaluator
from pathgene.host.problem.problem import Problem
from pathgene.host.terrain import Terrain
from tests.support.host.earth import places


GEODESICS = pyproj.Geod(ellps="WGS84")
# Reference system and south-west node: 1.6, -1.9, 2.3 and 0.0 degrees of convergence.
MAPS = {
    "EPSG:32616": (750_000, 4_000_000),
    "EPSG:32632": (280_000, 6_000_000),
    "EPSG:32717": (200_000, 6_000_000),
    "EPSG:32631": (500_000, 5_000_000),
}


def problem(crs="EPSG:32616", **options):
    terrain = Terrain(
        "made", np.full((101, 101), 100.0), 50.0, 50.0, crs, tuple(map(float, MAPS[crs]))
    )
    return Problem(terrain, (500.0, 500.0, 300.0), (4500.0, 4000.0, 300.0), **options)


def azimuth(terrain, direction):
    """Return the geodesic azimuth of a direction of the frame at the map's middle."""
    middle = np.array((terrain.width_m, terrain.height_m)) / 2
    lat, lon = places(terrain, [middle, middle + 100 * np.asarray(direction)])
    return GEODESICS.inv(lon[0], lat[0], lon[1], lat[1])[0] % 360


@pytest.mark.parametrize("crs", MAPS)
@pytest.mark.parametrize("heading", [0.0, 75.0, 250.0])
def test_a_heading(crs, heading):
    made = problem(crs, start_heading_deg=heading)
    found = azimuth(made.terrain, made.headings[0])
    # A tenth of a degree is not applied.
    near = 0.01 if made.north_deg else 0.1
    assert (found - heading + 180) % 360 - 180 == pytest.approx(0, abs=near)


@pytest.mark.parametrize("crs", MAPS)
def test_a_wind(crs):
    made = problem(crs, wind=(-3.0, 4.0))
    towards = math.degrees(math.atan2(-3.0, 4.0)) % 360
    near = 0.01 if made.north_deg else 0.1
    assert azimuth(made.terrain, made.frame_wind) == pytest.approx(towards, abs=near)
    assert math.hypot(*made.frame_wind) == pytest.approx(5.0, rel=1e-12)
    assert made.wind == (-3.0, 4.0)


def test_the_terms_of_a_path_are_those_of_the_turned_wind():
    made = problem(wind=(6.0, 2.0))
    bare = Terrain("bare", made.terrain.elevation, 50.0, 50.0)
    turned = Problem(bare, made.start, made.goal, wind=made.frame_wind)
    path = np.array([made.start, (2000.0, 3000.0, 320.0), made.goal])
    found, expected = (Evaluator(each, threads=1).evaluate(path) for each in (made, turned))
    assert found.flight_time_s == pytest.approx(expected.flight_time_s, rel=1e-12)
    straight = Problem(bare, made.start, made.goal, wind=made.wind)
    assert Evaluator(straight, threads=1).evaluate(path).flight_time_s != pytest.approx(
        expected.flight_time_s, rel=1e-4
    )


@pytest.mark.parametrize(
    ("crs", "options"),
    [
        ("EPSG:32631", {}),  # Less than a tenth of a degree.
        ("EPSG:32616", {"as_paper": True}),
    ],
)
def test_the_frame_is_kept_bit_for_bit(crs, options):
    made = problem(crs, wind=(-3.0, 4.0), **options)
    assert made.north_deg == 0.0
    assert made.frame_wind == (-3.0, 4.0)


def test_a_heading_of_the_frame_becomes_a_true_one():
    made = problem("EPSG:32717")
    heading = made.true_heading_deg(40.0)
    east, north = math.sin(math.radians(40)), math.cos(math.radians(40))
    assert azimuth(made.terrain, (east, north)) == pytest.approx(heading % 360, abs=0.01)


def test_the_page_of_rules_counts_headings_from_true_north():
    page = Path(__file__).parents[3] / "docs" / "rules.md"
    (row,) = [line for line in page.read_text().splitlines() if line.startswith("| `--start-head")]
    assert row.endswith("degrees clockwise from true north at the middle of the map |")
