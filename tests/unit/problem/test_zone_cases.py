"""Files from public reports, whose zones were once dropped, misplaced or refused."""

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.mission.build import mission_of
from tests.support.host.cases import CASES


pytestmark = pytest.mark.skipif(not CASES.is_dir(), reason="the cases are not here")
ENDS = {"start_geo": (59.985, 10.015, 80), "goal_geo": (60.015, 10.095, 80)}


def mission(file, terrain="geo60.tif", **values):
    (path,) = CASES.glob(file)
    source = str(path.parent / terrain)
    return mission_of({"terrain": source, "agl": True, "nofly": [str(path)], **ENDS, **values})


def said(read, grade):
    return [each.text for each in read.problem.zones_reading.remarks if each.grade == grade]


def box(zone, terrain):
    """Return west, south, east and north of a zone, degrees."""
    lat, lon = terrain.to_geographic(*np.array(zone.ring).T)
    return pytest.approx((lon.min(), lat.min(), lon.max(), lat.max()), abs=1e-6)


@pytest.mark.parametrize("name", ["swapped.geojson", "swapped.kml"])
def test_a_zone_with_swapped_coordinates_is_refused(name):
    with pytest.raises(InputError, match=r'"prison": it lies off the map.*the two swapped'):
        mission(f"05*/{name}")
    read = mission(f"05*/{name}", skip_bad_zones=True)
    assert read.problem.zones == ()
    assert any("prison" in text for text in said(read, "warning"))


def test_the_same_zone_the_right_way_round_is_read():
    (zone,) = mission("05*/right.geojson").problem.zones
    assert zone.name == "prison"


def test_a_closed_path_of_google_earth_is_a_zone():
    read = mission("07*/closed_path.kml")
    assert [zone.name for zone in read.problem.zones] == ["prison, drawn as a closed path", "small"]
    assert box(read.problem.zones[0], read.problem.terrain) == (10.038, 59.994, 10.062, 60.006)


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("networklink.kml", 'NetworkLink "all zones"'),
        ("groundoverlay.kml", 'GroundOverlay "range"'),
    ],
)
def test_parts_of_kml_that_may_hold_zones_are_named(name, part):
    read = mission(f"07*/{name}")
    assert [zone.name for zone in read.problem.zones] == ["small"]
    (warning,) = said(read, "warning")
    assert part in warning


@pytest.mark.parametrize(
    "name", ["ed318.geojson", "openaip.geojson", "text_limits.geojson", "prism_with_walls.kml"]
)
def test_limits_of_height_are_read(name):
    inside = {"start_geo": (59.99, 10.03, 80), "goal_geo": (60.01, 10.07, 80)}
    (zone,) = mission(f"12*/{name}", **inside).problem.zones
    assert zone.lower_m == pytest.approx(1400, abs=30)
    # Without a pressure at sea level a flight level may lie some hundred metres higher.
    assert 2890 <= zone.upper_m <= 3250


@pytest.mark.parametrize(
    ("name", "zone_name", "radius_m", "heights"),
    [
        ("ed269.json", "Airport", 500, ("0 m AGL", "120 m AGL")),
        ("ed318_circle.json", "GZ1", 500, ("0 m AGL", "120 m AGL")),
        ("openair.txt", "R-1 TEST", 926, ("GND", "FL 65")),
        ("inav_geozone.geojson", "Circle 1", 160, ("23 m AMSL", "120 m AMSL")),
    ],
)
def test_circles_of_the_formats_of_the_trade_are_read(name, zone_name, radius_m, heights):
    read = mission(f"15*/{name}")
    assert {zone.name for zone in read.problem.zones} == {zone_name}
    x, y = read.problem.terrain.to_local([60.0], [10.05])
    west, south, east, north = np.transpose([zone.footprint.box for zone in read.problem.zones])
    box = (west.min(), south.min(), east.max(), north.max())
    # The frame of the terrain differs from the ground by up to a thousandth.
    expected = (x[0] - radius_m, y[0] - radius_m, x[0] + radius_m, y[0] + radius_m)
    assert box == pytest.approx(expected, abs=1 + radius_m / 500)
    (zone,) = read.problem.zones_reading.facts["files"][0]["zones"]
    assert (zone["lower"], zone["upper"]) == heights


def test_an_airspace_from_the_ground_to_a_flight_level_is_one_zone():
    read = mission("15*/openair.txt")
    (zone,) = read.problem.zones
    assert (zone.lower_m, zone.radius_m) == (None, 926)
    assert not any("tile by tile" in text for text in said(read, "note"))


def test_fences_of_mission_planner_are_read():
    (zone,) = mission("15*/fence.waypoints").problem.zones
    assert len(zone.ring) == 3
    assert not zone.holes
    inside = {"start_geo": (59.995, 10.05, 80), "goal_geo": (60.005, 10.05, 80)}
    (zone,) = mission("15*/old.fen", **inside).problem.zones
    assert len(zone.holes[0]) == 3
    # The ends lie outside the inclusion polygon.
    with pytest.raises(InputError, match=r"^The start at .* is inside "):
        mission("15*/old.fen")


@pytest.mark.parametrize(
    ("name", "count", "part"),
    [
        ("null_geometry.geojson", 40, 'feature 21, "unlocated" left out: it has no geometry'),
        (
            "power_line.geojson",
            40,
            'feature 21, "power line" left out: a LineString is not an area',
        ),
        ("airport_point.geojson", 40, 'feature 21, "heliport" left out: a Point is not an area'),
        ("collection.geojson", 41, "41 zones read"),
    ],
)
def test_one_feature_that_is_no_area_is_named(name, count, part):
    read = mission(f"14*/{name}")
    assert len(read.problem.zones) == count
    assert any(part in text for text in said(read, "note"))


@pytest.mark.parametrize("name", ["unwrapped.geojson", "unwrapped.plan"])
def test_longitudes_beyond_180_are_unwrapped(name):
    read = mission(
        f"17*/{name}", "fiji.tif", start_geo=(-16.5, 179.975, 80), goal_geo=(-16.5, -179.978, 80)
    )
    (zone,) = read.problem.zones
    x, y = read.problem.terrain.to_local([-16.51, -16.49], [179.99, -179.99])
    assert zone.footprint.box == pytest.approx((x[0], y[0], x[1], y[1]), abs=60)


@pytest.mark.parametrize("name", ["epsg4258.geojson", "epsg4269.geojson"])
def test_datums_like_wgs84_are_read(name):
    read = mission(f"20*/{name}")
    (zone,) = read.problem.zones
    assert box(zone, read.problem.terrain) == (10.04, 59.995, 10.06, 60.005)


@pytest.mark.parametrize(
    ("name", "zone_name"),
    [
        ("latin1.kml", "Gefängnis"),
        ("utf16.kml", "Gefängnis"),
        ("undeclared_xsi.kml", "Gefängnis"),
        ("space_after_comma.kml", "z"),
    ],
)
def test_kml_that_google_earth_reads_is_read(name, zone_name):
    read = mission(f"21*/{name}")
    (zone,) = read.problem.zones
    assert zone.name == zone_name
    assert box(zone, read.problem.terrain) == (10.04, 59.995, 10.06, 60.005)
