"""``.fen``, the old fence: a return point and the inclusion polygon."""

import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats import fen
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad
from pathgene.host.formats.registry import read_features


POINTS = ("60.0, 10.05", "59.99\t10.04", "59.99 10.06", "60.01, 10.05", "59.99 10.04")


def content(*lines, name="download"):
    return Content("\n".join(lines).encode(), name)


def test_reads_the_polygon_after_the_return_point():
    file = content("#saved by a ground station", *POINTS, "")
    assert fen.recognises(file)
    (found,) = fen.features(file)
    assert found.rings == (((10.04, 59.99), (10.06, 59.99), (10.05, 60.01)),)
    assert (found.keeps_in, found.label) == (True, 'fence 1, "outside of the fence"')


@pytest.mark.parametrize(("first", "is_said"), [("40.0, 10.05", True), (POINTS[1], False)])
def test_a_return_point_outside_is_a_warning(first, is_said):
    (found,) = fen.features(content(first, *POINTS[1:], name="old.fen"))
    text = "its return point, the first row, lies outside; a corner there is not read"
    assert [each.text for each in found.remarks] == [text] * is_said
    (inside,) = fen.features(content(*POINTS, name="old.fen"))
    assert inside.remarks == ()


def test_the_polygon_may_be_open():
    (found,) = fen.features(content(*POINTS[:-1], name="old.fen"))
    assert len(found.rings[0]) == 3


@pytest.mark.parametrize(
    "lines", [("60 10",) * 4, ("60 10 5",) * 6, ("a b",) * 6, ("{}",), ("AC R", *POINTS)]
)
def test_takes_no_other_text(lines):
    assert not fen.recognises(content(*lines))


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize(
    ("corners", "name"),
    [
        ((*POINTS[:3], POINTS[0]), "field.poly"),
        ((*POINTS[:4], POINTS[0]), "field.poly"),
        ((*POINTS[:4], POINTS[0]), "download"),
        (POINTS[:4], "field.POLY"),
        (POINTS, "field.poly"),
    ],
)
def test_a_polygon_without_a_meaning_is_refused_with_the_remedy(tmp_path, corners, name, ending):
    file = tmp_path / name
    file.write_bytes(ending.join(("#saved by Mission Planner 1.3", *corners, "")).encode())
    with pytest.raises(InputError) as caught:
        read_features(file)
    why = "looks like a polygon of Mission Planner (.poly), which does not say whether to stay "
    assert why in str(caught.value)
    assert "save it as a .fen to stay inside, or as GeoJSON to stay outside" in str(caught.value)


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        (POINTS[:3], "a fence must have a return point and three corners or more."),
        (("60 10",) * 6, "a fence must have a return point and three corners or more."),
        ((*POINTS, "north 10"), "line 6 must be a latitude and a longitude."),
        (
            ("10.05 160.0", *(f"{-95 + at} 60" for at in range(4))),
            "(60, -95) is no WGS84 longitude and latitude; swapped",
        ),
    ],
)
def test_says_why_a_fence_is_bad(lines, reason):
    file = content(*lines, name="old.FEN")
    assert fen.recognises(file)
    (bad,) = fen.features(file)
    assert isinstance(bad, Bad)
    assert bad.label == "fence 1"
    assert bad.reason.startswith(reason.removesuffix(" swapped"))
