"""KML, read by fastkml."""

import numpy as np
import pytest
from fastkml import KML, Folder, Placemark
from fastkml.enums import AltitudeMode
from shapely.geometry import Point
from shapely.geometry import Polygon as Shape

from pathgene.host.formats import kml
from pathgene.host.problem.zones import Circle
from pathgene.host.report.track import track_of
from tests.support.host.earth import AGREE_M, agree, apart_m, places


def read(text):
    """Return the placemarks of the document: track, waypoints, zones."""
    (document,) = KML.from_string(text, strict=True).features
    (track,) = (feature for feature in document.features if isinstance(feature, Placemark))
    points, zones = (feature for feature in document.features if isinstance(feature, Folder))
    return track, points.features, zones.features


@pytest.mark.ci
def test_fastkml_reads_the_same_track_and_waypoints(missions, tracks):
    for (problem, path), track in zip(missions, tracks, strict=True):
        line, points, zones = read(kml.write(track_of(problem, path)).decode())
        assert len(zones) == len(problem.zones)
        assert line.kml_geometry.altitude_mode is AltitudeMode.absolute

        samples = track.sample(25.0)
        lon, lat, alt = np.array(line.geometry.coords).T
        assert agree(problem.terrain, np.column_stack((samples.x, samples.y)), lat, lon)
        assert np.array_equal(alt, samples.z)
        lon, lat, alt = np.array([point.geometry.coords[0] for point in points]).T
        assert agree(problem.terrain, path, lat, lon)
        assert np.array_equal(alt, path[:, 2])
        assert [points[0].name, points[-1].name] == ["Start", "Goal"]
        assert {point.kml_geometry.altitude_mode for point in points} == {AltitudeMode.absolute}


def corners(ring):
    """Return a ring without its closing corner as (lat, lon, altitudes)."""
    lon, lat, alt = np.array(ring.coords)[:-1].T
    return lat, lon, alt


@pytest.mark.ci
def test_fastkml_reads_the_zones_with_their_heights(missions):
    seen = set()
    for problem, path in missions:
        _, _, zones = read(kml.write(track_of(problem, path)).decode())
        for zone, placemark in zip(problem.zones, zones, strict=True):
            geometry = placemark.kml_geometry
            prism = zone.lower_m is not None
            lid = next(iter(placemark.geometry.geoms)) if prism else placemark.geometry
            lat, lon, alt = corners(lid.exterior)
            top = path[:, 2].max() if zone.upper_m is None else zone.upper_m
            assert alt.min() == alt.max()
            assert alt[0] == top or (zone.upper_m is None and alt[0] > top)
            if prism:
                assert corners(list(placemark.geometry.geoms)[1].exterior)[2].max() == zone.lower_m
            else:
                assert geometry.extrude
                assert geometry.altitude_mode is AltitudeMode.absolute
            if isinstance(zone, Circle):
                far = apart_m(
                    np.array(places(problem.terrain, [(zone.x_m, zone.y_m)] * len(lat))),
                    (lat, lon),
                )
                # The scale of the projection, and the corners of the polygon outside the circle.
                assert np.all(far > 0.998 * zone.radius_m)
                assert np.all(far < 1.003 * zone.radius_m)
            else:
                assert agree(problem.terrain, zone.ring, lat, lon)
                assert len(list(lid.interiors)) == len(zone.holes)
                for hole, inner in zip(zone.holes, lid.interiors, strict=True):
                    lat, lon, _ = corners(inner)
                    assert agree(problem.terrain, hole, lat, lon)
            seen.add((type(zone), prism, zone.upper_m is None))
    assert len(seen) == 8  # Circles and polygons with each combination of limits.


def test_a_circle_lies_inside_its_polygon(missions):
    for problem, path in missions[:30]:
        _, _, zones = read(kml.write(track_of(problem, path)).decode())
        for zone, placemark in zip(problem.zones, zones, strict=True):
            if isinstance(zone, Circle):
                lid = next(iter(placemark.geometry.geoms)) if zone.lower_m else placemark.geometry
                lat, lon, _ = corners(lid.exterior)
                shape = Shape(np.column_stack(problem.terrain.to_local(lat, lon)))
                circle = Point(zone.x_m, zone.y_m).buffer(zone.radius_m)  # Chords lie inside it.
                assert shape.buffer(AGREE_M).contains(circle)
                assert shape.area < 1.01 * circle.area
