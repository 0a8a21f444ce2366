"""GPX: the first route, or the first track, as a line; only read."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from pathgene.host.errors import InputError
from pathgene.host.formats.content import Content
from pathgene.host.formats.mission_items import AMSL, MissionFile, line_file
from pathgene.host.formats.placemarks import tag_of, text_of
from pathgene.host.numeric import parse
from pathgene.host.remarks import Grade, Remark


__all__ = ["holds_mission", "mission"]


def holds_mission(content: Content) -> bool:
    """Return whether a text is GPX."""
    return content.is_xml and content.xml is not None and tag_of(content.xml) == "gpx"


def mission(content: Content) -> MissionFile:
    """Return the points of the first route, or of the first track.

    Raises
    ------
    InputError
        If there is none, or a point has no height.
    """
    root = content.xml
    assert root is not None
    lines = [("route", each) for each in root if tag_of(each) == "rte"]
    lines += [("track", each) for each in root if tag_of(each) == "trk"]
    if not lines:
        raise InputError("it has no route and no track.")
    kind, line = lines[0]
    points = [each for each in line.iter() if tag_of(each) in ("rtept", "trkpt")]
    remarks: tuple[Remark, ...] = ()
    if len(lines) > 1:
        count = len(lines) - 1
        more = "1 more route or track is" if count == 1 else f"{count} more routes or tracks are"
        remarks = (Remark(Grade.WARNING, f"{more} in the file and not judged."),)
    segments = sum(tag_of(each) == "trkseg" for each in line)
    if segments > 1:
        text = f"the {segments} segments of the track are joined by straight legs."
        remarks = (*remarks, Remark(Grade.WARNING, text))
    if len(points) < 2:
        raise InputError(f"its {kind} must have two points or more.")
    places = [_place(kind, number, point) for number, point in enumerate(points, start=1)]
    return line_file(f"a {kind} of GPX", places, AMSL, remarks)


def _place(kind: str, number: int, point: ET.Element) -> tuple[float, float, float]:
    try:
        return (
            parse(point.get("lat", "")),
            parse(point.get("lon", "")),
            parse(text_of(point, "ele")),
        )
    except ValueError:
        raise InputError(
            f"point {number} of its {kind} must have lat, lon and a height (ele) in metres."
        ) from None
