"""Lines of KML as missions: the first line, or the waypoints of a file that pathgene wrote."""

from __future__ import annotations

from xml.etree import ElementTree as ET

from pathgene.host.errors import InputError
from pathgene.host.formats.mission_items import AMSL, TERRAIN, MissionFile, line_file
from pathgene.host.formats.placemarks import every, places_of, text_of
from pathgene.host.numeric import parse
from pathgene.host.remarks import Grade, Remark


__all__ = ["LINE", "kml_mission"]

#: Kind of a mission from a line that another program drew.
LINE = "a line of KML"

_FRAMES = {"absolute": AMSL, "relativeToGround": TERRAIN}


def kml_mission(root: ET.Element) -> MissionFile:
    """Return the line of a document.

    A file that pathgene wrote has a folder with the waypoints of its track; their numbers begin at
    0, as their names do.

    Raises
    ------
    InputError
        If there is no line, or its heights are not above the sea or above the ground.
    """
    own = _waypoints(root)
    if own:
        return line_file("waypoints of a KML of pathgene", own, AMSL, first=0)
    found = [
        (placemark, line)
        for placemark in every(root, "Placemark")
        for line in every(placemark, "LineString")
    ]
    if not found:
        raise InputError("there is no LineString in it.")
    placemark, line = found[0]
    name = _named(placemark)
    mode = text_of(line, "altitudeMode") or "clampToGround"
    if mode not in _FRAMES:
        raise InputError(
            f"the line {name}has the altitudeMode {mode}, so it has no heights; set absolute or "
            "relativeToGround."
        )
    points = [_point(name, each) for each in places_of(text_of(line, "coordinates"))]
    if len(points) < 2:
        raise InputError(f"the line {name}must have two points or more.")
    remarks: tuple[Remark, ...] = ()
    if len(found) > 1:
        others = ", ".join(_named(each).strip() or "one without a name" for each, _ in found[1:4])
        more = "1 more line is" if len(found) == 2 else f"{len(found) - 1} more lines are"
        text = f"{more} in the file and not judged: {others}."
        remarks = (Remark(Grade.WARNING, text),)
    return line_file(LINE, points, _FRAMES[mode], remarks)


def _waypoints(root: ET.Element) -> list[tuple[float, float, float]]:
    """Return the waypoints in a file of pathgene, or nothing."""
    tracks = (text_of(each, "styleUrl") == "#track" for each in every(root, "Placemark"))
    if not any(tracks):
        return []
    return [
        _point("of the waypoints ", text_of(point, "coordinates"))
        for folder in every(root, "Folder")
        if text_of(folder, "name") == "Waypoints"
        for point in every(folder, "Point")
        if text_of(point, "altitudeMode") == "absolute"
    ]


def _named(placemark: ET.Element) -> str:
    name = " ".join(text_of(placemark, "name").split())
    return f'"{name}" ' if name else ""


def _point(name: str, text: str) -> tuple[float, float, float]:
    """Return latitude, longitude and height of a position."""
    try:
        lon, lat, height = map(parse, text.split(","))
    except ValueError:
        raise InputError(
            f"the line {name}has the position {text[:60]!r}, which must be longitude, latitude "
            "and height."
        ) from None
    return lat, lon, height
