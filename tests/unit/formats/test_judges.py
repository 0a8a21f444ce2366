"""The reasons for readers of our own, as the page on the architecture states them."""

import io
import re
from importlib import metadata
from pathlib import Path

from aerofiles.openair import Reader
from fastkml import KML

from pathgene.host.formats import kml, openair
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Feature


ROOT = Path(__file__).parents[3]
NAMESPACE = ' xmlns="http://www.opengis.net/kml/2.2"'
RING = "9,45 9.01,45 9.01,45.01 9,45"
AREA = (
    f"<kml{NAMESPACE}><Placemark><Polygon><outerBoundaryIs><LinearRing><coordinates>{RING}"
    "</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></kml>"
)


def ours(reader, text):
    return list(reader.features(Content(text.encode())))


def theirs(text, *, strict=True):
    return list(KML.from_string(text, strict=strict).features)


def test_the_page_names_each_judge_of_zones_and_none_is_in_the_product():
    page = (ROOT / "docs" / "architecture.md").read_text()
    (part,) = re.findall(r"### Readers of zones, and their judges\n(.*?)\n## ", page, re.DOTALL)
    required = [
        re.match(r"[\w-]+", line)[0]
        for line in metadata.requires("pathgene")
        if "extra ==" not in line
    ]
    for judge in ("aerofiles", "fastkml", "uas-standards", "shapely"):
        assert f"`{judge}`" in part
        assert judge not in required
    for own in ("defusedxml", "pyproj"):
        assert f"`{own}`" in part
        assert own in required


def test_aerofiles_refuses_places_without_separators_and_leaves_limits_as_texts():
    text = "AC R\nAN R-7\nAL GND\nAH FL 95\nV X={}\nDC 3\n"
    plain, bare = (text.format(place) for place in ("60:01:30 N 010:03:00 E", "600130N 0100300E"))
    ((record, error),) = Reader(io.StringIO(plain))
    assert error is None
    assert (record["floor"], record["ceiling"]) == ("GND", "FL 95")
    ((record, error),) = Reader(io.StringIO(bare))
    assert record is None
    assert "invalid coordinate format" in str(error)
    assert ours(openair, plain) == ours(openair, bare)


def test_fastkml_finds_nothing_without_a_namespace_or_in_an_old_one():
    assert len(theirs(AREA)) == 1
    for other in ("", NAMESPACE.replace("www.opengis.net/kml/2.2", "earth.google.com/kml/2.0")):
        text = AREA.replace(NAMESPACE, other)
        assert theirs(text) == []
        assert isinstance(ours(kml, text)[0], Feature)


def test_fastkml_drops_bad_polygons_and_needs_a_library_under_the_lgpl():
    bad = AREA.replace("9.01,45.01", "9.01,x")
    (found,) = theirs(bad, strict=False)
    assert found.geometry is None
    assert isinstance(ours(kml, bad)[0], Bad)
    for name in ("fastkml", "pygeoif"):
        assert "LGPL" in metadata.metadata(name)["License"]
    assert any(line.startswith("pygeoif") for line in metadata.requires("fastkml"))
