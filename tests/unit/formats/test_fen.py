"""``.fen``, the old fence: a return point and the inclusion polygon."""

import pytest

from pathgene.host.formats import fen
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad


POINTS = ("60.0, 10.05", "59.99\t10.04", "59.99 10.06", "60.01, 10.05", "59.99 10.04")


def content(*lines, name="download"):
    return Content("\n".join(lines).encode(), name)


def test_reads_the_polygon_after_the_return_point():
    file = content("#saved by a ground station", *POINTS, "")
    assert fen.recognises(file)
    (found,) = fen.features(file)
    assert found.rings == (((10.04, 59.99), (10.06, 59.99), (10.05, 60.01)),)
    assert (found.keeps_in, found.label) == (True, 'fence 1, "outside of the fence"')


def test_the_polygon_may_be_open():
    (found,) = fen.features(content(*POINTS[:-1], name="old.fen"))
    assert len(found.rings[0]) == 3


@pytest.mark.parametrize(
    "lines", [("60 10",) * 4, ("60 10 5",) * 6, ("a b",) * 6, ("{}",), ("AC R", *POINTS)]
)
def test_takes_no_other_text(lines):
    assert not fen.recognises(content(*lines))


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
