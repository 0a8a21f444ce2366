"""KMZ: the document of an archive, and archives that are refused."""

import io
import zipfile

import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats import kml, kmz
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import LeftOut
from pathgene.host.inputs import MOST_TEXT_BYTES


POLYGON = (
    "<Placemark><name>{}</name><Polygon><outerBoundaryIs><LinearRing><coordinates>"
    "10,60 10.1,60 10.1,60.1 10,60</coordinates></LinearRing></outerBoundaryIs></Polygon>"
    "</Placemark>"
)
LINK = "<NetworkLink><name>more</name><Link><href>zones/more.kml</href></Link></NetworkLink>"


def document(*parts):
    return (
        f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document>{"".join(parts)}</Document></kml>'
    )


def archive(files, name="zones.kmz", method=zipfile.ZIP_DEFLATED):
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", method) as opened:
        for path, text in files.items():
            opened.writestr(path, text)
    return Content(data.getvalue(), name)


def names(content):
    return [getattr(part, "name", None) for part in kmz.features(content)]


def test_reads_the_document_like_the_same_kml():
    text = document(POLYGON.format("R-7"), POLYGON.format("Łódź"))
    content = archive({"files/a.png": b"\x89PNG", "doc.kml": text}, name="download")
    assert kmz.recognises(content)
    assert list(kmz.features(content)) == list(kml.features(Content(text.encode())))
    assert names(content) == ["R-7", "Łódź"]


def test_reads_a_document_in_its_declared_encoding():
    text = '<?xml version="1.0" encoding="UTF-16"?>' + document(POLYGON.format("Ål"))
    assert names(archive({"doc.kml": text.encode("utf-16")})) == ["Ål"]


def test_doc_is_the_main_document_else_the_first():
    one, other = document(POLYGON.format("one")), document(POLYGON.format("other"))
    left_out = LeftOut("'more/a.kml' in the archive", "only the first document is read", True)
    found = list(kmz.features(archive({"more/a.kml": one, "Doc.KML": other})))
    assert [found[0].name, found[1]] == ["other", left_out]
    found = list(kmz.features(archive({"b.kml": other, "more/a.kml": one})))
    assert [found[0].name, found[1]] == ["other", left_out]


def test_names_network_links():
    content = archive({"doc.kml": document(POLYGON.format("R-7"), LINK)})
    _, link = sorted(kmz.features(content), key=lambda part: isinstance(part, LeftOut))
    assert link.is_suspicious
    assert "more" in link.label + link.reason


def refusal(content):
    assert kmz.recognises(content)
    with pytest.raises(InputError) as caught:
        list(kmz.features(content))
    return str(caught.value)


def test_refuses_a_document_that_unpacks_to_too_much():
    content = archive({"doc.kml": b" " * (MOST_TEXT_BYTES + 1)})
    assert len(content.data) < 100_000
    assert refusal(content) == "'doc.kml' in the archive unpacks to more than 64 MB."


def test_refuses_an_archive_of_too_many_files(monkeypatch):
    monkeypatch.setattr(kmz, "_MOST_FILES", 2)
    content = archive({"doc.kml": document(), "a": "", "b": ""})
    assert refusal(content) == "the archive has more than 2 files."


@pytest.mark.parametrize("kept", [10, 100])
def test_refuses_a_broken_archive(kept):
    whole = archive({"doc.kml": document(POLYGON.format("R-7"))})
    content = Content(whole.data[:kept], "zones.kmz")
    assert refusal(content) == "the archive is broken; save it again."


def test_refuses_a_broken_document():
    whole = archive({"doc.kml": document(POLYGON.format("R-7"))}, method=zipfile.ZIP_STORED)
    data = whole.data.replace(b"R-7", b"R-8")
    reason = "'doc.kml' in the archive is broken or encrypted; save it again."
    assert refusal(Content(data, "zones.kmz")) == reason


def test_refuses_an_encrypted_document():
    data = bytearray(archive({"doc.kml": document(POLYGON.format("R-7"))}).data)
    for signature, offset in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        data[data.index(signature) + offset] |= 1
    reason = "'doc.kml' in the archive is broken or encrypted; save it again."
    assert refusal(Content(bytes(data), "zones.kmz")) == reason


def test_refuses_an_archive_without_a_document():
    assert refusal(archive({"a.shp": b"x"})) == "the archive has no .kml document."
    assert not kmz.recognises(archive({"a.shp": b"x"}, name="zones.zip"))
    assert not kmz.recognises(Content(document().encode(), "zones.kmz"))
