"""Files of zones that are deep or wide: the time to read them grows with their size alone."""

import time

import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats import kml
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Feature


# Processor time; a quadratic reader takes minutes.
SOON_S = 10


def drawn(places):
    """Return a polygon with corners at longitudes, latitudes and altitudes."""
    text = " ".join(f"{x:.6f},{y:.6f},{z}" for x, y, z in places)
    return (
        "<Polygon><altitudeMode>absolute</altitudeMode><outerBoundaryIs><LinearRing><coordinates>"
        f"{text}</coordinates></LinearRing></outerBoundaryIs></Polygon>"
    )


def polygon(x, y):
    return drawn([(x, y, 0), (x + 0.0004, y, 0), (x, y + 0.0004, 0), (x, y, 0)])


def wall(x, y):
    east = x + 0.0004
    return drawn([(x, y, 0), (east, y, 0), (east, y, 90), (x, y, 90), (x, y, 0)])


def nested(tag, depth, inside, more=""):
    return f"<{tag}>{more}" * depth + inside + f"</{tag}>" * depth


SQUARE = f"<Placemark>{polygon(9, 46)}</Placemark>"
TIME = "<TimeSpan><begin>2026</begin></TimeSpan>"
RING = "<LinearRing><coordinates>9,46,0 9.1,46,0 9,46.1,0 9,46,0</coordinates></LinearRing>"
PLACES = [(9 + 0.001 * number, 46) for number in range(6000)]
LARGE = {
    "folders": nested("Folder", 40_000, SQUARE),
    "folders with times": nested("Folder", 40_000, SQUARE, TIME),
    "placemarks": nested("Placemark", 40_000, polygon(9, 46)),
    "placemarks with names": nested("Placemark", 40_000, polygon(9, 46), "<name>x</name>"),
    "geometries": f"<Placemark>{nested('MultiGeometry', 40_000, polygon(9, 46))}</Placemark>",
    "boundaries": f"<Placemark><Polygon>{nested('outerBoundaryIs', 40_000, RING)}</Polygon>"
    "</Placemark>",
    "polygons and walls": "<Placemark><MultiGeometry>"
    + "".join(polygon(*place) + wall(*place) for place in PLACES)
    + "</MultiGeometry></Placemark>",
    "walls": "<Placemark><MultiGeometry>"
    + "".join(wall(*place) for place in PLACES)
    + "</MultiGeometry></Placemark>",
}


@pytest.mark.parametrize("name", LARGE)
def test_kml(name):
    content = Content(f"<kml><Document>{LARGE[name]}</Document></kml>".encode())
    begun_s = time.process_time()
    try:
        found = [each for each in kml.features(content) if isinstance(each, Feature)]
    except InputError:
        found = []
    assert time.process_time() - begun_s < SOON_S
    if name == "polygons and walls":
        assert len(found) == len(PLACES)
        assert found[0].upper.height_m == 90
    elif name != "walls":
        assert len(found) == 1


@pytest.mark.parametrize("text", ["x " * 50_000, "lat lon " * 12_000, "a" * 100_000])
def test_a_text_of_no_format_is_named_quickly(text):
    begun_s = time.process_time()
    assert Content(text.encode()).looks_like == ""
    assert time.process_time() - begun_s < 2
