"""Missions in a ``.plan`` of any ground station: simple items, surveys and corridors.

A changed mission is written into the document that it was read from, whose other members stay.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.formats.mission_items import (
    ARDUPILOT,
    PX4,
    Entry,
    Home,
    MissionFile,
    MissionItem,
)
from pathgene.host.numeric import as_number, integer, numbers


__all__ = ["changed_plan", "new_plan", "plan_mission"]

_AUTOPILOTS = {3: ARDUPILOT, 12: PX4}
_VERSION = 2
# AltitudeMode of QGroundControl for the frames of heights: above the sea, above home, above the
# ground by the autopilot's terrain; and the mode whose altitudes QGroundControl computes.
_MODES = {0: 2, 5: 2, 3: 1, 6: 1, 10: 4, 11: 4}
_CALCULATED, _ABSOLUTE = 3, 2
# Complex items whose flight is stored in the file.
_TRANSECTS = {"survey": "survey", "CorridorScan": "corridor"}
_NAMES = {
    "StructureScan": "structure scan",
    "fwLandingPattern": "landing pattern of a fixed wing",
    "vtolLandingPattern": "landing pattern of a VTOL",
    "LandingPattern": "landing pattern",
}


def plan_mission(document: Any) -> MissionFile:
    """Return the mission of a ``.plan``.

    Surveys and corridors are flown by the items that the ground station stored with them.

    Raises
    ------
    InputError
        If it has no mission, an item is bad, or another complex item is in it.
    """
    try:
        mission = document["mission"]
        if document["version"] != 1:
            raise InputError(
                f"it is a .plan of version {document['version']!r}, and only 1 is known; save it "
                "with QGroundControl."
            )
        if mission["version"] != _VERSION:
            raise InputError(
                f"its mission has version {mission['version']!r}; save it with a newer "
                "QGroundControl."
            )
        listed = list(mission["items"])
        home = _home(mission.get("plannedHomePosition"))
        fences = document.get("geoFence") or {}
        rally = document.get("rallyPoints") or {}
        points = tuple(numbers(point, 3) for point in rally.get("points") or ())
        has_fences = bool(fences.get("circles") or fences.get("polygons"))
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError("it is not a .plan file of QGroundControl, version 1.") from None
    items = tuple(_numbered(listed))
    if not items:
        raise InputError("its mission has no items.")
    return MissionFile(
        "a .plan of QGroundControl",
        items,
        home,
        points,
        _AUTOPILOTS.get(mission.get("firmwareType"), ""),
        has_fences,
    )


def _numbered(listed: list[Any]) -> Iterator[MissionItem]:
    """Yield the items; a number is the one for jumps, or the place where the file has none."""
    last = 0
    for place, table in enumerate(listed, start=1):
        for own, within in _simple_items(place, table):
            stated = own.get("doJumpId")
            last = stated if isinstance(stated, int) and stated > last else last + 1
            yield _item(last, own, within)


def _simple_items(place: int, table: Any) -> Iterator[tuple[dict[str, Any], str]]:
    """Yield the simple items of an item, with the name of the complex one."""
    if not isinstance(table, dict):
        raise InputError(f"item {place} is not an object.")
    if table.get("type") == "SimpleItem":
        yield table, ""
        return
    kind = str(table.get("complexItemType", table.get("type")))
    if kind not in _TRANSECTS:
        raise InputError(
            f"item {place} is a {_NAMES.get(kind, kind)}, which cannot be judged; replace it by "
            "waypoints, as an autopilot gets it: upload the mission, download it and save it."
        )
    transects = table.get("TransectStyleComplexItem")
    items = transects.get("Items") if isinstance(transects, dict) else None
    if not isinstance(items, list) or not items:
        raise InputError(
            f"item {place} is a {_TRANSECTS[kind]} without stored transects; open and save it "
            "with QGroundControl."
        )
    for own in items:
        if not isinstance(own, dict):
            raise InputError(f"item {place} is a {_TRANSECTS[kind]} with a bad transect.")
        yield own, f"{_TRANSECTS[kind]} {place}"


def _item(number: int, table: dict[str, Any], within: str) -> MissionItem:
    try:
        *params, lat, lon, alt = (None if p is None else as_number(p) for p in table["params"])
        first, second, third, fourth = params
        command, frame = integer("command", table["command"]), integer("frame", table["frame"])
    except (KeyError, TypeError, ValueError, InputError):
        raise InputError(
            f"item {number} must have command, frame and seven params, numbers or null."
        ) from None
    if not lat and not lon:
        lat = lon = None
    return MissionItem(
        number, command, frame, (first, second, third, fourth), lat, lon, alt, within
    )


def _home(stated: Any) -> Home | None:
    if stated is None:
        return None
    lat, lon, *rest = stated
    alt = rest[0] if rest else None
    place = as_number(lat), as_number(lon)
    return None if place == (0.0, 0.0) else (*place, None if alt is None else as_number(alt))


def changed_plan(
    document: Any, entries: Sequence[Entry], rally: Sequence[tuple[float, float, float]]
) -> Any:
    """Return the document of a ``.plan`` with a changed mission.

    Surveys keep their definitions; the items stored with them change.

    Parameters
    ----------
    document : dict
        A document from which :func:`plan_mission` reads a mission.
    entries : sequence of Entry
        The items as they are to be written.
    rally : sequence of (float, float, float)
        As many rally points as the document has.
    """
    items = plan_mission(document).items
    document = copy.deepcopy(document)
    mission = document["mission"]
    owners = [
        (top, own)
        for place, top in enumerate(mission["items"], start=1)
        for own, _ in _simple_items(place, top)
    ]
    written: list[Any] = []
    inner: list[Any] = []
    for entry in entries:
        if entry.place is None:
            (inner if entry.item.within else written).append(_new(entry.item))
            continue
        top, own = owners[entry.place]
        is_simple = top is own
        if not is_simple and not any(each is top for each in written):
            inner = top["TransectStyleComplexItem"]["Items"] = []
            written.append(top)
        _change(own, items[entry.place], entry.item)
        (written if is_simple else inner).append(own)
    mission["items"] = written
    points = (document.get("rallyPoints") or {}).get("points") or ()
    for point, place in zip(points, rally, strict=True):
        point[:3] = place
    return document


def new_plan(mission: MissionFile) -> dict[str, Any]:
    """Return the document of a new ``.plan`` with a mission that has home and no fences."""
    firmwares = {name: value for value, name in _AUTOPILOTS.items()}
    assert mission.home is not None
    lat, lon, alt_m = mission.home
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": {
            "version": _VERSION,
            "firmwareType": firmwares.get(mission.autopilot, 0),
            "vehicleType": 1,
            "globalPlanAltitudeMode": _MODES.get(mission.items[0].frame, _ABSOLUTE),
            "cruiseSpeed": 15,
            "hoverSpeed": 5,
            "plannedHomePosition": [lat, lon, alt_m or 0],
            "items": [_new(item) for item in mission.items],
        },
        "geoFence": {"version": 2, "circles": [], "polygons": []},
        "rallyPoints": {"version": 2, "points": [list(point) for point in mission.rally]},
    }


def _new(item: MissionItem) -> dict[str, Any]:
    """Return a new simple item."""
    table: dict[str, Any] = {
        "type": "SimpleItem",
        "autoContinue": True,
        "command": item.command,
        "doJumpId": item.number,
        "frame": item.frame,
        "params": [*item.params, item.lat or 0, item.lon or 0, item.alt_m],
    }
    if item.lat is not None:
        mode = _MODES.get(item.frame, _ABSOLUTE)
        table |= {"AltitudeMode": mode, "Altitude": item.alt_m, "AMSLAltAboveTerrain": None}
    return table


def _change(table: dict[str, Any], before: MissionItem, after: MissionItem) -> None:
    """Change a simple item; the altitudes that a ground station shows change with its height."""
    if "doJumpId" in table:
        table["doJumpId"] = after.number
    params = list(table["params"])
    for at, (was, now) in enumerate(zip(before.params, after.params, strict=True)):
        if was != now:
            params[at] = now
    if (before.lat, before.lon) != (after.lat, after.lon):
        params[4:6] = after.lat, after.lon
        # The ground station would compute another altitude at the new place.
        if table.get("AltitudeMode") == _CALCULATED:
            table["AltitudeMode"] = _ABSOLUTE
            table |= {"Altitude": after.alt_m, "AMSLAltAboveTerrain": None}
            before = after
    if before.alt_m != after.alt_m or params[6] != after.alt_m:
        up_m = (after.alt_m or 0.0) - (before.alt_m or 0.0)
        params[6] = after.alt_m
        for name in ("Altitude", "AMSLAltAboveTerrain"):
            if isinstance(table.get(name), int | float):
                table[name] = round(table[name] + up_m, 3)
    table["params"] = params
