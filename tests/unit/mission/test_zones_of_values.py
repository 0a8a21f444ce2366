"""Zones of the values of a problem: the choices on how their files are read."""

import json
from datetime import UTC, datetime

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.mission import build
from pathgene.host.mission.build import mission_of
from pathgene.host.problem.zones import ReadZones
from pathgene.host.terrain import Terrain


TERRAIN = Terrain("plain", np.full((41, 61), 50.0), 100.0, 100.0, "EPSG:32632", (4e5, 5.1e6))
ENDS = {"start": (500.0, 500.0, 150.0), "goal": (5500.0, 3500.0, 150.0)}


def zone_file(folder, *rings, **properties):
    features = [
        {
            "type": "Feature",
            "properties": {"name": f"R-{number}", **properties},
            "geometry": {"type": "Polygon", "coordinates": [ring]},
        }
        for number, ring in enumerate(rings, start=1)
    ]
    file = folder / "zones.geojson"
    document = {"type": "FeatureCollection", "crs_local": True, "features": features}
    file.write_text(json.dumps(document))
    return str(file)


def square(x, y, size=400.0):
    return [[x, y], [x + size, y], [x + size, y + size], [x, y + size], [x, y]]


@pytest.fixture
def asked(monkeypatch):
    """Record the choices with which files are read."""
    found = []

    def read_zones(file, terrain, options):
        found.append(options)
        return ReadZones()

    monkeypatch.setattr(build, "read_zones", read_zones)
    return found


def test_choices_reach_each_file(asked):
    mission_of(
        {
            **ENDS,
            "nofly": ["a.geojson"],
            "zones": [{"file": "b.geojson"}],
            "departure": "2026-05-01T09:00+02:00",
            "qnh": 1000.0,
            "forbid": "default,E",
            "skip_bad_zones": True,
            "ceiling": 900.0,
        },
        TERRAIN,
    )
    first, second = asked
    assert first == second
    assert first.departure == datetime(2026, 5, 1, 7, tzinfo=UTC)
    assert (first.qnh_hpa, first.skip_bad, first.ceiling_m) == (1000.0, True, 900.0)
    assert {"E", "CTR"} <= first.forbid
    assert "G" not in first.forbid
    # Twenty times across the map, at the aircraft's speed.
    assert 3600 < first.longest_s < 6 * 3600


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"departure": "tomorrow"}, "The departure must be a date and time with a time zone"),
        ({"departure": "9999-12-31T23:59Z"}, "The departure must be .* from 1900 to 2199"),
        ({"departure": "0001-01-01T00:00+14:00"}, "The departure must be .* from 1900 to 2199"),
        ({"departure": "2026-05-01T09:00"}, "The departure must be a date and time with a time"),
        ({"qnh": 29.92}, "The pressure at sea level must be 850 to 1100 hPa, not 29.92"),
        ({"forbid": "CTR,nonsense"}, "There is no class of airspace 'nonsense'"),
    ],
)
def test_bad_choices_are_refused_without_any_file(values, sentence):
    with pytest.raises(InputError, match=f"^{sentence}"):
        mission_of({**ENDS, **values}, TERRAIN)


def test_a_mission_keeps_the_report(tmp_path):
    file = zone_file(tmp_path, square(2000, 2000), square(3000, 1000), upper=20)
    mission = mission_of({**ENDS, "nofly": [file]}, TERRAIN)
    (read,) = mission.problem.zones_reading.facts["files"]
    assert (read["file"], read["read"], read["on_map"], read["can_forbid"]) == (file, 2, 2, 0)
    assert mission.problem.zones_reading.warnings == (
        "zones.geojson: 2 zones read as GeoJSON; 2 touch the map, 0 can forbid flight.",
        'zones.geojson: feature 1, "R-1", feature 2, "R-2" forbid nothing: their upper limits are '
        "under the ground everywhere.",
    )


def test_a_table_that_forbids_nothing_is_a_warning():
    tables = [
        {"polygon": square(2000.0, 2000.0), "name": "R-1"},
        {"polygon": square(2000.0, 2000.0), "name": "town", "upper": 40.0},
        {"polygon": square(2000.0, 2000.0), "upper": "-5 m AGL"},
        {"polygon": square(2000.0, 2000.0), "name": "later", "t0": 1e5},
    ]
    values = {**ENDS, "zones": tables, "nofly_circle": [(9e4, 0.0, 50.0)]}
    assert mission_of(values, TERRAIN).problem.zones_reading.warnings == (
        'Zone 2, "town", zone 3 forbid nothing: their upper limits are under the ground '
        "everywhere.",
        'Zone 4, "later" forbids nothing: it is not active during the flight.',
        "Zone 5 forbids nothing: it lies off the map.",
    )
    assert mission_of({**values, "as_paper": True}, TERRAIN).problem.zones_reading.warnings == ()


def test_the_report_has_the_choices(tmp_path):
    file = zone_file(tmp_path, square(2000, 2000))
    values = {**ENDS, "nofly": [file], "qnh": 1000.0, "departure": "2026-05-01T09:00Z"}
    read = mission_of(values, TERRAIN).problem.zones_reading
    assert read.facts["options"] == {"qnh": 1000.0, "departure": "2026-05-01T09:00Z"}


def test_a_point_in_a_zone_names_the_zone(tmp_path):
    file = zone_file(tmp_path, square(2000, 2000), square(400, 400))
    with pytest.raises(InputError) as refusal:
        mission_of({**ENDS, "nofly": [file]}, TERRAIN)
    assert str(refusal.value) == (
        "The start at (500, 500) is inside the no-fly zone R-2; move it or the zone."
    )
    via = {"via": [(2100.0, 2100.0, 150.0)]}
    file = zone_file(tmp_path, square(2000, 2000))
    with pytest.raises(InputError, match=r"is inside the no-fly zone R-1; move it or the zone\.$"):
        mission_of({**ENDS, **via, "nofly": [file]}, TERRAIN)
