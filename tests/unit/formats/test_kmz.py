"""KMZ: the document of an archive, and archives that are refused."""

import io
import zipfile

import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats import kml, kmz
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad
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


def test_reads_every_document_of_the_archive_the_main_one_first():
    one, other = document(POLYGON.format("one")), document(POLYGON.format("other"))
    found = list(kmz.features(archive({"more/a.kml": one, "Doc.KML": other})))
    assert [each.label for each in found] == [
        'placemark 1, "other"',
        'more/a.kml: placemark 1, "one"',
    ]
    assert names(archive({"b.kml": other, "more/a.kml": one})) == ["other", "one"]
    # A main document that has links only.
    assert names(archive({"doc.kml": document(LINK), "zones/more.kml": one})) == ["one"]
    # A document without areas is no fault.
    assert names(archive({"doc.kml": one, "empty.kml": document()})) == ["one"]


@pytest.mark.parametrize("address", ["zones/more.kml", "./zones/More.kml", "zones/m%6Fre.kml"])
def test_a_link_to_a_document_of_the_archive_is_read(address):
    link = LINK.replace("zones/more.kml", address)
    files = {"doc.kml": document(POLYGON.format("R-7"), link)}
    inside = archive({**files, "zones/more.kml": document(POLYGON.format("R-8"))})
    assert names(inside) == ["R-7", "R-8"]
    back = LINK.replace("zones/more.kml", "../doc.kml").replace("Link><href", "Url><href")
    back = back.replace("</href></Link>", "</href></Url>")
    inside = archive({**files, "zones/more.kml": document(POLYGON.format("R-8"), back)})
    assert names(inside) == ["R-7", "R-8"]
    (_, left_out) = kmz.features(archive(files))
    assert left_out.label == 'NetworkLink "more"'
    assert left_out.is_suspicious


def test_names_an_archive_in_the_archive():
    files = {"doc.kml": document(POLYGON.format("R-7")), "b.kmz": b"PK"}
    _, left_out = kmz.features(archive(files))
    assert left_out.label == "'b.kmz' in the archive"
    assert left_out.is_suspicious


def test_names_a_bad_document_and_reads_the_others():
    good, bad = (
        document(POLYGON.format("R-7")),
        document(POLYGON.format("R-8")).replace("<kml", "<gpx"),
    )
    bad_zone = POLYGON.format("R-9").replace("10,60", "here")
    found = list(
        kmz.features(archive({"doc.kml": good, "a.kml": bad, "b.kml": document(bad_zone)}))
    )
    assert found[0].name == "R-7"
    assert found[1].label == "'a.kml' in the archive"
    assert found[1].reason.startswith("not KML: ")
    assert found[2].label == 'b.kml: placemark 1, "R-9"'
    assert all(isinstance(each, Bad) for each in found[1:])


def test_all_documents_together_unpack_to_a_limited_size(monkeypatch):
    main, more = document(POLYGON.format("R-7")), document(POLYGON.format("R-8"))
    files = {"doc.kml": main, "a.kml": more, "b.kml": more + " " * 500, "c.kml": more}
    monkeypatch.setattr(kmz, "MOST_TEXT_BYTES", len(main) + len(more) + 400)
    found = list(kmz.features(archive(files)))
    assert [getattr(each, "name", None) for each in found] == ["R-7", "R-8", None, None]
    assert [each.label for each in found[2:]] == [
        "'b.kml' in the archive",
        "'c.kml' in the archive",
    ]
    assert {each.reason for each in found[2:]} == {
        "the documents unpack to more than 64 MB with it."
    }


def test_a_broken_document_besides_the_main_one_is_named():
    whole = archive(
        {"doc.kml": document(POLYGON.format("R-7")), "a.kml": document(POLYGON.format("R-8"))},
        method=zipfile.ZIP_STORED,
    )
    _, bad = kmz.features(Content(whole.data.replace(b"R-8", b"R-9"), "zones.kmz"))
    assert bad == Bad("'a.kml' in the archive", "it is broken or encrypted; save it again.")


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
