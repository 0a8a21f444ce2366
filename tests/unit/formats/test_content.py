"""Texts of two bytes a character without a mark, and sequences of JSON."""

import json
import time

import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats.content import Content
from pathgene.host.formats.registry import FORMATS, read_features


RING = [[10.0, 60.0], [10.1, 60.0], [10.1, 60.1], [10.0, 60.0]]
OPENAIR = """AC R
AN Zürich
AL GND
AH FL 65
DP 60:00 N 010:00 E
DP 60:00 N 010:06 E
DP 60:06 N 010:06 E
"""
KML = (
    "<kml><Placemark><name>Zürich</name><Polygon><outerBoundaryIs><LinearRing><coordinates>"
    "10,60 10.1,60 10.1,60.1</coordinates></LinearRing></outerBoundaryIs></Polygon>"
    "</Placemark></kml>"
)


def zone(name, **more):
    geometry = {"type": "Polygon", "coordinates": [RING]}
    return {"type": "Feature", "properties": {"name": name, **more}, "geometry": geometry}


def read(data):
    content = Content(data)
    row = next(row for row in FORMATS if row.zones and row.module.recognises(content))
    return row.name, list(row.module.features(content))


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be", "utf-16", "utf-8"])
@pytest.mark.parametrize(
    ("text", "kind"), [(json.dumps(zone("Zürich"), ensure_ascii=False), "geojson"),
                       (OPENAIR, "openair"), (KML, "kml"), (f"\n {KML}", "kml")]
)  # fmt: skip
def test_reads_text_of_two_bytes_a_character_without_a_mark(text, kind, encoding):
    found, parts = read(text.encode(encoding))
    assert (found, [part.name for part in parts]) == (kind, ["Zürich"])


@pytest.mark.parametrize(
    "data",
    [bytes(1000), bytes(range(256)) * 4, b"\x00\x00\x27\x0a" + bytes(96), b"a\0b\0\0\0c\0" * 9],
)
def test_other_files_with_many_zeros_are_binary(data):
    assert not Content(data).is_text


@pytest.mark.parametrize("text", ["lat ", "POLYGON" + " " * 99_000, "x;", "SRID=1"])
def test_a_long_line_is_named_in_a_short_time(text):
    content = Content((text * (100_000 // len(text))).encode())
    began = time.process_time()
    assert isinstance(content.looks_like, str)
    assert time.process_time() - began < 1.0


SEQUENCES = {
    "lines": "\n".join,
    "lines of Windows": "\r\n".join,
    "lines with blank ones": lambda texts: "\n\n".join(texts) + "\n\n",
    "separators": lambda texts: "".join(f"\x1e{text}\n" for text in texts),
}


@pytest.mark.parametrize("join", SEQUENCES.values(), ids=SEQUENCES)
def test_reads_sequences_of_features(join):
    texts = [json.dumps(zone(f"R-{number}\u2028", note="a\x1eb")) for number in range(3)]
    kind, parts = read(join(texts).encode())
    assert kind == "geojson"
    assert [part.label for part in parts] == [f'feature {n + 1}, "R-{n}"' for n in range(3)]


def test_separated_texts_may_have_several_lines():
    text = "".join(f"\x1e{json.dumps(zone(name), indent=1)}\n" for name in ("a", "b"))
    assert [part.name for part in read(text.encode())[1]] == ["a", "b"]


def test_reads_sequences_of_collections_geometries_and_other_formats():
    collection = {"type": "FeatureCollection", "features": [zone("a"), zone("b")]}
    bare = zone("")["geometry"]
    text = "\n".join(map(json.dumps, (collection, bare, zone("c"))))
    assert [part.name for part in read(text.encode())[1]] == ["a", "b", "", "c"]
    layer = {"upper": 120, "upperReference": "AGL"}
    feature = {**zone("x"), "geometry": {**bare, "layer": layer}}
    feature["properties"] = {"identifier": "GZ1", "type": "PROHIBITED"}
    kind, parts = read("\n".join([json.dumps(feature)] * 2).encode())
    assert (kind, [part.upper.height_m for part in parts]) == ("ed318", [120, 120])


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('{"type": "Feature"}\n{"type": ', "is not JSON: line 2 of the sequence: Expecting value"),
        ('\x1e{"type": "Feature"}\n\x1e{', "is not JSON: text 2 of the sequence: Expecting"),
        ('{"type": "Feature"}\n[1]', "is not JSON: Extra data: line 2"),
        ("{\n]", "is not JSON: Expecting property name"),
        ('{"name": "x", "lat": [1, 2', "is not JSON: Expecting ',' delimiter"),
        ("Dear Anna, the zones are attached.", "is in no format that is known; give GeoJSON, "),
    ],
)
def test_names_the_broken_line_of_a_sequence(tmp_path, text, reason):
    file = tmp_path / "zones.geojsonl"
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        read_features(file)
    assert reason in str(caught.value)
