"""Paths as GeoJSON."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats.geojson import heights_datum, path_document, read_path
from pathgene.host.problem.zones import Circle, Polygon, read_zones
from pathgene.host.report.track import mark_names, track_of
from pathgene.host.terrain import Terrain


UTM = {"crs": "EPSG:32632", "origin": (400_000.0, 5_130_000.0)}


def documented(make_run, **options):
    evaluator, result = make_run(**options)
    bare = replace(track_of(evaluator.problem, result.path), zones=())
    return evaluator.problem.terrain, result, path_document(bare, step_m=50.0)


def written(tmp_path, document):
    file = tmp_path / "path.geojson"
    file.write_text(document if isinstance(document, str) else json.dumps(document))
    return file


def test_local_metres_are_exact(make_run, tmp_path):
    terrain, result, document = documented(make_run)
    assert document["crs_local"] is True
    kinds = [feature["geometry"]["type"] for feature in document["features"]]
    assert kinds == ["LineString", "LineString", "Point", "Point"]
    assert document["features"][2]["geometry"]["coordinates"] == result.path[0].tolist()
    assert document["features"][3]["geometry"]["coordinates"] == result.path[-1].tolist()
    assert np.array_equal(read_path(written(tmp_path, document), terrain), result.path)


def test_wgs84_is_exact_to_the_millimetre(make_run, tmp_path):
    terrain, result, document = documented(make_run, **UTM)
    assert "crs_local" not in document
    longitude, latitude, altitude = document["features"][0]["geometry"]["coordinates"][0]
    # 400 km easting in zone 32 is 100 km west of 9 degrees east.
    assert (round(longitude, 1), round(latitude, 1)) == (7.7, 46.3)
    assert altitude == result.path[0, 2]
    assert all(number == round(number, 9) for number in (longitude, latitude))
    again = read_path(written(tmp_path, document), terrain)
    assert np.abs(again - result.path).max() < 1e-3


def test_second_feature_is_the_smoothed_track(make_run):
    _, result, document = documented(make_run)
    waypoints, track = (
        np.array(feature["geometry"]["coordinates"]) for feature in document["features"][:2]
    )
    assert np.array_equal(waypoints, result.path)
    assert np.array_equal(track[[0, -1]], result.path[[0, -1]])
    steps = np.linalg.norm(np.diff(track, axis=0), axis=1)
    assert steps.max() <= 50.0 * (1 + 1e-9)
    assert steps.sum() == pytest.approx(result.evaluation.length_m, rel=1e-3)


def test_the_marks_of_a_mission_have_kinds_and_are_no_zones(make_run, tmp_path):
    evaluator, result = make_run()
    problem = evaluator.problem
    start, goal = map(tuple, result.path[[0, -1]].tolist())
    way = (start, (900.0, 900.0, 900.0), goal, start)
    points = tuple(zip(mark_names(way), way, strict=True))
    track = replace(track_of(problem, result.path), points=points)
    document = path_document(track, step_m=50.0)
    marks = [feature["properties"] for feature in document["features"][2:6]]
    assert [(mark["kind"], mark["name"]) for mark in marks] == [
        ("start", "Start"),
        ("via", "Via 1"),
        ("goal", "Goal"),
        ("return", "Return"),
    ]
    assert len(read_zones(written(tmp_path, document), problem.terrain).zones) == len(problem.zones)


def test_zones_are_read_back_in_local_metres(make_run, tmp_path):
    evaluator, result = make_run()
    problem = evaluator.problem
    document = path_document(track_of(problem, result.path), step_m=50.0)
    assert [feature["properties"]["kind"] for feature in document["features"][4:]] == ["zone"] * 2
    circle, polygon = read_zones(written(tmp_path, document), problem.terrain).zones
    assert circle == problem.zones[0]
    assert set(polygon.ring) == set(problem.zones[1].ring)


def test_many_zones_on_earth_are_each_read_back_in_its_place(make_run, tmp_path):
    evaluator, result = make_run(**UTM)
    terrain = evaluator.problem.terrain
    square, hole = ((0.0, 0.0), (900.0, 0.0), (900.0, 900.0)), ((700.0, 100.0), (800.0, 100.0))
    zones = [Circle(37.0 * i, 11.0 * i, 5.0 + i, name=f"zone {i}") for i in range(100)]
    zones[40:40] = [
        Polygon(square, ((*hole, (800.0, 200.0)),)),
        Polygon(square[::-1], name="plain"),
    ]
    shapes = tuple(zone.shape for zone in zones)
    track = replace(track_of(evaluator.problem, result.path), zones=shapes)
    document = path_document(track, step_m=50.0)
    again = read_zones(written(tmp_path, document), terrain).zones
    assert [type(zone) for zone in again] == [type(zone) for zone in zones]
    for zone, read in zip(zones, again, strict=True):
        assert read.name == zone.name
        if isinstance(zone, Circle):
            found = (read.x_m, read.y_m, read.radius_m)
            assert found == pytest.approx((zone.x_m, zone.y_m, zone.radius_m), abs=1e-3)
        else:
            assert len(read.holes) == len(zone.holes)
            for before, after in zip(
                (zone.ring, *zone.holes), (read.ring, *read.holes), strict=True
            ):
                apart = np.hypot(*(np.array(before)[:, None] - np.array(after)).T)
                assert len(after) == len(before)
                assert apart.min(axis=0).max() < 1e-3


@pytest.mark.parametrize(
    ("crs", "source", "heights"),
    [
        (
            None,
            "synthetic",
            "AMSL (the datum of the terrain 'hills', which its file does not name)",
        ),
        ("EPSG:32632", "/dem/N46E007.hgt", "AMSL (EGM96, the geoid of SRTM)"),
        (None, "SRTM 3 arc-second (NASA, USGS)", "AMSL (EGM96, the geoid of SRTM)"),
        ('COMPD_CS["a",VERT_CS["EGM2008 height",', "", "AMSL (EGM2008 height)"),
    ],
)
def test_states_what_heights_are_measured_from(make_run, crs, source, heights):
    terrain = Terrain("hills", np.zeros((2, 2)), 1.0, 1.0, crs, (0.0, 0.0), source)
    assert heights_datum(terrain) == heights
    _, _, document = documented(make_run)
    assert document["heights"].startswith("AMSL (")


@pytest.mark.parametrize(
    "wrap",
    [
        lambda line: line,
        lambda line: {"type": "Feature", "properties": {}, "geometry": line},
        lambda line: {
            "type": "FeatureCollection",
            "features": [
                {"type": "Feature", "geometry": {"type": "Point", "coordinates": [0, 0]}},
                {"type": "Feature", "geometry": line},
            ],
        },
    ],
    ids=["geometry", "feature", "collection"],
)
def test_reads_any_wrapping(make_run, tmp_path, wrap):
    evaluator, _ = make_run()
    document = wrap({"type": "LineString", "coordinates": [[1, 2, 3], [4, 5, 6]]})
    path = read_path(written(tmp_path, {**document, "crs_local": True}), evaluator.problem.terrain)
    assert path.tolist() == [[1, 2, 3], [4, 5, 6]]


@pytest.mark.parametrize(
    ("document", "sentence"),
    [
        ("{", "{}: not JSON; give GeoJSON, a CSV or a summary."),
        (
            [1],
            "{}: there is no LineString in it to take as the path; give GeoJSON with one, a CSV or "
            "a summary.",
        ),
        (
            {"type": "FeatureCollection", "features": 3},
            "{}: there is no LineString in it to take as the path; give GeoJSON with one, a CSV or "
            "a summary.",
        ),
        (
            {"type": "LineString", "coordinates": [[1, 2], [3, 4]]},
            "{}: the LineString must have two or more positions of three numbers each, the "
            "third the "
            "altitude.",
        ),
        (
            {"type": "LineString", "coordinates": [[1, 2, 3], [3, "a", 4]]},
            "{}: the LineString must have two or more positions of three numbers each, the "
            "third the "
            "altitude.",
        ),
        (
            {"type": "LineString", "coordinates": [[1, 2, 3], [3, 4, 5]]},
            "{}: its positions are geographic, which a terrain without a coordinate "
            "reference system "
            'cannot place; give local metres with "crs_local": true.',
        ),
    ],
)
def test_refuses_bad_documents(make_run, tmp_path, document, sentence):
    evaluator, _ = make_run()
    file = written(tmp_path, document)
    expected = sentence.replace("{}", str(file))
    with pytest.raises(InputError, match=f"^{re.escape(expected)}$"):
        read_path(file, evaluator.problem.terrain)


def test_refuses_a_missing_file(make_run, tmp_path):
    evaluator, _ = make_run()
    with pytest.raises(InputError, match=r"^Cannot read the path '.*' \(No such file or dir"):
        read_path(tmp_path / "missing.geojson", evaluator.problem.terrain)
