"""``.plan`` of QGroundControl: a mission and its fences, written, uploaded and read as zones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.files.output import json_bytes, reading
from pathgene.host.formats.areas import check_degrees
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Bad, Edges, Feature, Read, label
from pathgene.host.formats.flight_plan import (
    CHANGE_SPEED,
    RTL,
    Fence,
    FenceCircle,
    FencePolygon,
    FlightPlan,
    Item,
)
from pathgene.host.formats.mission_items import Entry, MissionFile
from pathgene.host.formats.plan_mission import changed_plan, plan_mission
from pathgene.host.formats.track import Track
from pathgene.host.inputs import parse_json, read_text
from pathgene.host.numeric import as_number, integer, numbers, rows
from pathgene.host.version import version


__all__ = [
    "changed",
    "features",
    "holds_mission",
    "mission",
    "plan_document",
    "read_plan",
    "recognises",
    "write",
]

# Constants of MAVLink: any autopilot, a fixed wing, altitudes above mean sea level.
_GENERIC_AUTOPILOT = 0
_FIXED_WING = 1
_FRAME_GLOBAL = 0
# AltitudeModeAbsolute of QGroundControl's QGroundControlQmlGlobal.h, the mode of frame 0.
# SimpleMissionItem::load() takes mode and frame without comparing them. With mode 1, relative to
# home, amslEntryAlt() adds the altitude of home to AMSL altitudes, so the editor shows the path too
# high above the ground; and whatever sets an item's frame from the mode, or adds an item to a plan
# of that mode, makes AMSL altitudes relative ones for the aircraft too.
_ALTITUDE_MODE = 2
# The file requires a hover speed as well; an aeroplane has none.
_HOVER_SPEED_M_S = 5.0
# Our own member of the file, which ground stations ignore and do not save.
_MARK = "pathgene"


def write(track: Track) -> bytes:
    """Return the flight plan of a track as a ``.plan`` file."""
    return json_bytes(plan_document(track.flown))


def changed(
    content: Content, entries: Sequence[Entry], rally: Sequence[tuple[float, float, float]]
) -> bytes:
    """Return a ``.plan`` with a changed mission; see :func:`changed_plan`."""
    return json_bytes(changed_plan(content.json, entries, rally))


def plan_document(plan: FlightPlan) -> dict[str, Any]:
    """Return the content of a ``.plan`` file."""
    return {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": {
            "version": 2,
            "firmwareType": _GENERIC_AUTOPILOT,
            "vehicleType": _FIXED_WING,
            "globalPlanAltitudeMode": _ALTITUDE_MODE,
            "cruiseSpeed": plan.cruise_speed_m_s,
            "hoverSpeed": _HOVER_SPEED_M_S,
            "plannedHomePosition": list(plan.home),
            "items": [_simple(number, item) for number, item in enumerate(plan.items, start=1)],
        },
        "geoFence": {
            "version": 2,
            "circles": [
                {
                    "version": 1,
                    "inclusion": fence.inclusion,
                    "circle": {"center": [fence.lat, fence.lon], "radius": fence.radius_m},
                }
                for fence in plan.fence
                if isinstance(fence, FenceCircle)
            ],
            "polygons": [
                {
                    "version": 1,
                    "inclusion": fence.inclusion,
                    "polygon": [list(corner) for corner in fence.corners],
                }
                for fence in plan.fence
                if isinstance(fence, FencePolygon)
            ],
        },
        "rallyPoints": {"version": 2, "points": [list(point) for point in plan.rally]},
        **_mark(plan),
    }


def _simple(number: int, item: Item) -> dict[str, Any]:
    """Return an item; one without a place, such as a change of speed, has no altitude."""
    height = {
        "AltitudeMode": _ALTITUDE_MODE,
        "Altitude": item.alt_m,
        "AMSLAltAboveTerrain": None,
    }
    return {
        "type": "SimpleItem",
        "doJumpId": number,
        "command": item.command,
        "frame": _FRAME_GLOBAL,
        "params": [*item.params, item.lat, item.lon, item.alt_m],
        "autoContinue": True,
        **(height if item.command not in (CHANGE_SPEED, RTL) else {}),
    }


def read_plan(file: Path) -> FlightPlan:
    """Return the content of a ``.plan`` file of simple items at altitudes above mean sea level.

    Raises
    ------
    InputError
        If the file cannot be read or holds anything else: surveys, altitudes above home or above
        ground, fences of another version.
    """
    try:
        with reading("plan", file):
            document = parse_json(read_text(file))
    except ValueError:
        raise InputError(f"{file}: not JSON; give a .plan file or a summary.json.") from None
    try:
        return _plan(document)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None
    except (KeyError, TypeError, ValueError, AttributeError, IndexError):
        raise InputError(f"{file}: not a .plan file of QGroundControl, version 1.") from None


def _mark(plan: FlightPlan) -> dict[str, Any]:
    """Return the member with the verdict on the path, if there is one, and an unusual datum."""
    if plan.feasible is None:
        return {}
    heights = {"heights": plan.heights} if plan.heights else {}
    return {_MARK: {"version": version(), "feasible": plan.feasible, **heights}}


def _plan(document: dict[str, Any]) -> FlightPlan:
    mission, geofence = document["mission"], document["geoFence"]
    if document["fileType"] != "Plan" or document["version"] != 1 or mission["version"] != 2:
        raise ValueError
    if geofence["version"] != 2:
        raise InputError("its fences are of another version than 2; save it with a newer program.")
    feasible = document[_MARK]["feasible"] if _MARK in document else None
    if not isinstance(feasible, bool | None):
        raise InputError(f"feasible of {_MARK} must be true or false, not {feasible!r}.")
    return FlightPlan(
        numbers(mission["plannedHomePosition"], 3),
        tuple(_item(number, item) for number, item in enumerate(mission["items"], start=1)),
        tuple(_fences(geofence)),
        tuple(numbers(point, 3) for point in document["rallyPoints"]["points"]),
        as_number(mission["cruiseSpeed"]),
        feasible=feasible,
    )


def _item(number: int, item: dict[str, Any]) -> Item:
    if item["type"] != "SimpleItem":
        raise InputError(
            f"item {number} is a {item.get('complexItemType', item['type'])}, but only waypoints "
            "and other simple items can be read; replace it by waypoints."
        )
    if item["frame"] != _FRAME_GLOBAL:
        raise InputError(
            f"item {number} has an altitude of frame {item['frame']}; give altitudes above mean "
            "sea level (frame 0)."
        )
    try:
        *params, lat, lon, alt_m = item["params"]
        first, second, third, fourth = (None if p is None else as_number(p) for p in params)
        lat, lon, alt_m = numbers((lat, lon, alt_m), 3)
    except (TypeError, ValueError):
        raise InputError(
            f"the params of item {number} are not seven finite numbers, of which the first four "
            "may be null; mend the item."
        ) from None
    return Item(
        integer("command", item["command"]), (first, second, third, fourth), lat, lon, alt_m
    )


def _fences(geofence: dict[str, Any]) -> Iterator[Fence]:
    for circle in geofence["circles"]:
        lat, lon = numbers(circle["circle"]["center"], 2)
        radius_m = as_number(circle["circle"]["radius"])
        yield FenceCircle(lat, lon, radius_m, _keeps_in(circle))
    for polygon in geofence["polygons"]:
        corners = tuple(numbers(corner, 2) for corner in polygon["polygon"])
        yield FencePolygon(corners, _keeps_in(polygon))


def _keeps_in(fence: Any) -> bool:
    """Return whether a fence is one to stay in.

    Raises
    ------
    InputError
        If its member ``inclusion`` is missing, or neither true nor false.
    """
    if not isinstance(fence, dict) or "inclusion" not in fence:
        raise InputError('a fence has no member "inclusion"; give true (stay in) or false.')
    value = fence["inclusion"]
    # A text such as "false" would be true.
    if not isinstance(value, bool | int | float) or value not in (0, 1):
        raise InputError(f'"inclusion" of a fence must be true or false, not {value!r}.')
    return bool(value)


def recognises(content: Content) -> bool:
    """Return whether a text is the JSON of a ``.plan``."""
    return isinstance(content.json, dict) and content.json.get("fileType") == "Plan"


def holds_mission(content: Content) -> bool:
    """Return whether a text is the JSON of a ``.plan``."""
    return recognises(content)


def mission(content: Content) -> MissionFile:
    """Return the mission of a plan; see :func:`plan_mission`."""
    return plan_mission(content.json)


def features(content: Content) -> Iterator[Read]:
    """Yield the fences of a plan, circles first.

    A fence to stay in has ``keeps_in``: a path then keeps within all such fences.

    Raises
    ------
    InputError
        If the fences have another version, or none is given.
    """
    try:
        fences = content.json["geoFence"]
        if fences["version"] != 2:
            raise InputError(
                "its fences are of another version than 2; save it with a newer program."
            )
        circles, polygons = list(fences["circles"]), list(fences["polygons"])
    except (KeyError, TypeError):
        raise InputError("it has no geoFence of QGroundControl.") from None
    if not circles and not polygons:
        raise InputError("there is no fence in it.")
    # The edges of a plan of our own are straight in the frame of the terrain.
    edges = Edges.FRAME if _MARK in content.json else Edges.DEGREES
    for kind, listed in (("circle", circles), ("polygon", polygons)):
        for number, item in enumerate(listed, start=1):
            try:
                yield _fence_feature(kind, number, item, edges)
            except (KeyError, TypeError, ValueError, InputError) as error:
                why = f" ({str(error).rstrip('.')})" if isinstance(error, InputError) else ""
                yield Bad(label(f"fence {kind}", number), f"the {kind} is bad{why}.")


def _fence_feature(kind: str, number: int, item: Any, edges: Edges) -> Feature:
    """Return a fence.

    Raises
    ------
    KeyError, TypeError, ValueError, InputError
        If it is bad.
    """
    radius_m = None
    keeps_in = _keeps_in(item)
    if kind == "circle":
        corners = [item["circle"]["center"]]
        radius_m = as_number(item["circle"]["radius"])
        if radius_m <= 0:
            raise ValueError
    else:
        corners = item["polygon"]
    ring = tuple((lon, lat) for lat, lon in rows(corners, 2).tolist())
    check_degrees(ring, "latitude comes first.")
    return Feature(
        number,
        f"outside of fence {kind} {number}" if keeps_in else "",
        (ring,),
        radius_m,
        edges=edges,
        kind=f"fence {kind}",
        keeps_in=keeps_in,
    )
