"""Start, goal and via points as users give them, and the mistakes that are recognised."""

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.problem.ends import check_above_ground, end_point, place
from pathgene.host.terrain import Terrain


#: 3 x 2 km in the hills of the UTM zone 16, at 300 m.
PLACED = Terrain("hills", np.full((21, 31), 300.0), 100, 100, "EPSG:32616", (747_000, 4_013_000))
LOCAL = Terrain("local", np.full((21, 31), 300.0), 100, 100)
LATITUDE, LONGITUDE = PLACED.to_geographic(1000.0, 500.0)


def refusal(function, *arguments, **options):
    with pytest.raises(InputError) as error:
        function(*arguments, **options)
    return str(error.value)


def test_a_point_in_degrees_above_the_ground():
    x, y, z = end_point("start", (LATITUDE, LONGITUDE, 60), PLACED, agl=True, geo=True)
    assert (x, y) == pytest.approx((1000, 500), abs=1e-3)
    assert z == 360


def test_longitude_before_latitude():
    """Both are latitudes by their size; only the map tells them apart."""
    assert refusal(place, "goal", LONGITUDE, LATITUDE, PLACED) == (
        f"The goal at latitude {LONGITUDE:g} and longitude {LATITUDE:g} is outside the map, but on "
        "it with the two swapped: latitude first?"
    )


def test_a_latitude_beyond_the_pole():
    assert refusal(place, "start", -122.5, 37.5, PLACED) == (
        "The start has the latitude -122.5, which must be from -90 to 90 degrees: latitude first?"
    )


def test_degrees_off_the_map_either_way_are_placed_there():
    """The problem says how far the map reaches."""
    x, y = place("start", 45.0, 45.0, PLACED)
    assert "outside the map, which reaches" in refusal(
        check_above_ground, "start", PLACED, (x, y, 400.0)
    )


@pytest.mark.parametrize("point", [(LATITUDE, LONGITUDE), (-122.5, 37.5)])
def test_degrees_need_a_reference_system(point):
    assert refusal(place, "start", *point, LOCAL) == (
        "The terrain 'local' has no coordinate reference system, so latitude and longitude have no "
        "meaning on it; give local metres."
    )


def test_easting_and_northing_for_local_metres():
    assert refusal(check_above_ground, "via point 2", PLACED, (748_000.5, 4_013_700, 400.0)) == (
        "The via point 2 at (748000.5, 4013700) is outside the map, which reaches from (0, 0) to "
        "(3000, 2000) m; as easting and northing in EPSG:32616 it is on the map, so give its local "
        "metres, 1000.50,700.00."
    )
    assert refusal(end_point, "start", (748_000.5, 4_013_700, 60.0), PLACED, agl=True).endswith(
        "so give its local metres, 1000.50,700.00."
    )


def test_feet_east_and_north():
    feet = Terrain("feet", np.full((3, 3), 10.0), 100, 100, "EPSG:2285", (1_000_000, 200_000))
    assert refusal(check_above_ground, "start", feet, (1_000_100, 200_050, 40.0)).endswith(
        "so give its local metres, 30.48,15.24."
    )


@pytest.mark.parametrize("terrain", [PLACED, LOCAL])
def test_other_points_off_the_map_have_no_hint(terrain):
    assert refusal(check_above_ground, "goal", terrain, (3100, 500, 400.0)) == (
        "The goal at (3100, 500) is outside the map, which reaches from (0, 0) to (3000, 2000) m."
    )


@pytest.mark.parametrize(
    ("z", "remedy"),
    [
        (60.0, "raise it, or give --agl if 60 m is its height above the ground."),
        (0.0, "raise it, or give --agl if 0 m is its height above the ground."),
        (-5.0, "raise it."),
    ],
)
def test_a_height_above_ground_for_an_altitude(z, remedy):
    assert refusal(check_above_ground, "start", LOCAL, (100, 100, z)) == (
        f"The start at an altitude of {z:g} m is inside the ground, which is at 300 m there; "
        f"{remedy}"
    )


def test_a_high_altitude_is_no_height_above_ground():
    high = Terrain("high", np.full((3, 3), 4000.0), 100, 100)
    assert refusal(check_above_ground, "start", high, (100, 100, 3900.0)).endswith("; raise it.")
