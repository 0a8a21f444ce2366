"""Files of a path: the formats, and GeoJSON read by geopandas."""

import json

import geopandas
import numpy as np
import pytest
from fastkml import KML

from pathgene.host.errors import InputError
from pathgene.host.formats.registry import files, parse_formats
from pathgene.host.mission.export import exported
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.way import WayProblem
from pathgene.host.problem.zones import Circle, read_zones
from pathgene.host.terrain import Terrain
from tests.support.host.earth import agree


def export(problem, path, formats, folder, note):
    """Write the files; return their paths."""
    contents = exported(problem, path, formats, note)
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    return [folder / name for name in contents]


def test_geopandas_reads_the_same_path_and_zones(missions, tracks, tmp_path):
    for (problem, path), track in zip(missions, tracks, strict=True):
        (file,) = export(problem, path, ["geojson"], tmp_path, pytest.fail)
        frame = geopandas.read_file(file)
        assert frame.crs == "EPSG:4326"
        zones = ["zone"] * len(problem.zones)
        assert list(frame["kind"]) == ["waypoints", "smoothed track", "start", "goal", *zones]
        samples = track.sample(min(problem.terrain.dx_m, problem.terrain.dy_m))
        smooth = np.column_stack((samples.x, samples.y, samples.z))
        shapes = list(frame.geometry)
        for shape, points in zip(shapes, (path, smooth, path[:1], path[-1:]), strict=False):
            lon, lat, alt = np.array(shape.coords).T
            assert agree(problem.terrain, points, lat, lon)
            assert np.array_equal(alt, points[:, 2])
        for (_, row), zone in zip(frame[4:].iterrows(), problem.zones, strict=True):
            if isinstance(zone, Circle):
                assert row["radius_m"] == zone.radius_m
                points, shape = [(zone.x_m, zone.y_m)], row.geometry
                lon, lat = np.array(shape.coords)[:, :2].T
            else:
                assert row.geometry.exterior.is_ccw
                lon, lat = np.array(row.geometry.exterior.coords)[:-1].T
                ring = np.array(zone.ring)
                area = np.sum(ring[:, 0] * (np.roll(ring[:, 1], -1) - np.roll(ring[:, 1], 1)))
                points = ring if area > 0 else ring[::-1]
            assert agree(problem.terrain, points, lat, lon)
            for key, value in zone.limits.items():
                assert row[key] == value


def test_the_zones_of_a_path_file_are_read_back(missions, tmp_path):
    for problem, path in missions[:20]:
        (file,) = export(problem, path, ["geojson"], tmp_path, pytest.fail)
        read = read_zones(file, problem.terrain).zones
        assert [zone.limits for zone in read] == [zone.limits for zone in problem.zones]


@pytest.mark.parametrize("returns", [False, True])
def test_marks_are_those_of_the_mission(missions, tmp_path, returns):
    problem, path = next(mission for mission in missions if len(mission[1]) > 4)
    via, goal = tuple(path[2]), tuple(path[-2] if returns else path[-1])
    if returns:
        path = np.array([*path[:-1], path[0]])
    way = (path[0], via, goal, path[0]) if returns else (path[0], via, goal)
    whole = WayProblem(problem.terrain, tuple(map(tuple, way)), zones=problem.zones, as_paper=True)
    (file, kml) = export(whole, path, ["geojson", "kml"], tmp_path, pytest.fail)
    names = ["Start", "Via 1", "Goal", *(["Return"] if returns else [])]
    frame = geopandas.read_file(file)
    marks = frame[2 : 2 + len(names)]
    assert list(marks["name"]) == names
    assert list(marks["kind"]) == ["start", "via", "goal", "return"][: len(names)]
    lon, lat = np.array([shape.coords[0][:2] for shape in marks.geometry]).T
    assert agree(problem.terrain, way, lat, lon)
    zones = read_zones(file, problem.terrain).zones
    assert [zone.limits for zone in zones] == [zone.limits for zone in problem.zones]

    titles = [f"Waypoint {number}" for number in range(len(path))]
    for name, index in zip(names, (0, 2, len(path) - 1 - returns, len(path) - 1), strict=False):
        titles[index] = name
    (document,) = KML.from_string(kml.read_text(), strict=True).features
    folder = next(part for part in document.features if part.name == "Waypoints")
    assert [placemark.name for placemark in folder.features] == titles


def test_writes_each_format(missions, tmp_path):
    problem, path = next(mission for mission in missions if mission[0].zones)
    formats = parse_formats("kml, plan,waypoints,kml")
    assert formats == ("kml", "plan", "waypoints")
    written = export(problem, path, formats, tmp_path, lambda _sentence: None)
    assert [file.name for file in written] == ["path.kml", "path.plan", "path.waypoints"]
    assert sorted(tmp_path.iterdir()) == sorted(written)
    assert json.loads(written[1].read_text())["fileType"] == "Plan"


@pytest.mark.parametrize("text", ["plan,gpx", ""])
def test_refuses_an_unknown_format(text):
    name = text.partition(",")[2]
    with pytest.raises(InputError) as refusal:
        parse_formats(text)
    assert str(refusal.value) == (
        f"There is no file format {name!r}; give some of plan, waypoints, kml, geojson, html "
        "(--write)."
    )


def test_needs_a_place_on_earth(tmp_path):
    terrain = Terrain("canyon", np.zeros((21, 21)), 100.0, 100.0)
    problem = Problem(terrain, (100, 100, 90), (1900, 1900, 90))
    path = np.array([problem.start, problem.goal])
    for name in set(files()) - {"geojson", "html"}:
        with pytest.raises(InputError) as refusal:
            export(problem, path, [name], tmp_path, pytest.fail)
        assert str(refusal.value) == (
            "The terrain 'canyon' has no place on Earth, which this file needs; give the latitude "
            "and longitude of its south-west node (--origin LAT,LON, or origin under [terrain] in "
            "a problem file)."
        )
    (file,) = export(problem, path, ["geojson"], tmp_path, pytest.fail)
    assert json.loads(file.read_text())["crs_local"] is True
