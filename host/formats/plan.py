"""``.plan`` of QGroundControl: a mission and its fences, written, uploaded and read as zones."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pathgene.host.errors import InputError
from pathgene.host.files.output import json_bytes, reading
from pathgene.host.formats.content import Content
from pathgene.host.formats.flight_plan import Fence, FenceCircle, FencePolygon, FlightPlan, Item
from pathgene.host.formats.shapes import Ring, Shape
from pathgene.host.formats.track import Track
from pathgene.host.inputs import parse_json, read_text
from pathgene.host.numeric import as_number, integer, numbers, rows
from pathgene.host.terrain import Terrain
from pathgene.host.version import version


__all__ = ["plan_document", "read_plan", "recognises", "write", "zones"]

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
# A fence to stay in becomes a zone around it, this many metres beyond the map and the fence.
_BEYOND_M = 1000.0
# Corners of the polygon inside a circle to stay in.
_CIRCLE_CORNERS = 180


def write(track: Track) -> bytes:
    """Return the flight plan of a track as a ``.plan`` file."""
    return json_bytes(plan_document(track.flown))


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
            "items": [
                {
                    "type": "SimpleItem",
                    "doJumpId": number,
                    "command": item.command,
                    "frame": _FRAME_GLOBAL,
                    "params": [*item.params, item.lat, item.lon, item.alt_m],
                    "autoContinue": True,
                    "AltitudeMode": _ALTITUDE_MODE,
                    "Altitude": item.alt_m,
                    "AMSLAltAboveTerrain": None,
                }
                for number, item in enumerate(plan.items, start=1)
            ],
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
    """Return the member that states the verdict on the path, if there is one."""
    if plan.feasible is None:
        return {}
    return {_MARK: {"version": version(), "feasible": plan.feasible}}


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
    *params, lat, lon, alt_m = item["params"]
    first, second, third, fourth = (None if p is None else as_number(p) for p in params)
    lat, lon, alt_m = numbers((lat, lon, alt_m), 3)
    return Item(
        integer("command", item["command"]), (first, second, third, fourth), lat, lon, alt_m
    )


def _fences(geofence: dict[str, Any]) -> Iterator[Fence]:
    for circle in geofence["circles"]:
        lat, lon = numbers(circle["circle"]["center"], 2)
        radius_m = as_number(circle["circle"]["radius"])
        yield FenceCircle(lat, lon, radius_m, bool(circle["inclusion"]))
    for polygon in geofence["polygons"]:
        corners = tuple(numbers(corner, 2) for corner in polygon["polygon"])
        yield FencePolygon(corners, bool(polygon["inclusion"]))


def recognises(content: Content) -> bool:
    """Return whether a text is the JSON of a ``.plan``."""
    return isinstance(content.json, dict) and content.json.get("fileType") == "Plan"


def zones(content: Content, terrain: Terrain) -> Iterator[Shape]:
    """Yield the fences of a plan as zones.

    A fence to keep out of is the circle or polygon itself. A fence to stay in becomes the rest of
    the map: a rectangle with the fence as its hole, so that a path keeps within all such fences. A
    circle to stay in is a polygon of 180 corners on it.

    Raises
    ------
    InputError
        If the fences have another version, one is bad, none is given, or the terrain has no place
        on Earth.
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
    if terrain.crs is None:
        raise InputError(
            "the terrain has no coordinate reference system, so fences have no place on it; give "
            "--origin LAT,LON, or origin under [terrain] in a problem file."
        )
    for number, circle in enumerate(circles, start=1):
        try:
            (centre,) = _local([circle["circle"]["center"]], terrain)
            radius_m, inclusion = as_number(circle["circle"]["radius"]), circle["inclusion"]
            if radius_m <= 0:
                raise ValueError
        except (KeyError, TypeError, ValueError):
            raise InputError(f"circle {number} of its fence is bad.") from None
        if inclusion:
            angles = np.linspace(0, 2 * np.pi, _CIRCLE_CORNERS, endpoint=False)
            x, y = centre[0] + radius_m * np.cos(angles), centre[1] + radius_m * np.sin(angles)
            ring: Ring = tuple(zip(x.tolist(), y.tolist(), strict=True))
            yield _outside(ring, terrain, f"outside of fence circle {number}")
        else:
            yield Shape("Point", ((centre,),), {"radius_m": radius_m})
    for number, polygon in enumerate(polygons, start=1):
        try:
            ring, inclusion = _local(polygon["polygon"], terrain), polygon["inclusion"]
        except (KeyError, TypeError, ValueError):
            raise InputError(f"polygon {number} of its fence is bad.") from None
        if inclusion:
            yield _outside(ring, terrain, f"outside of fence polygon {number}")
        else:
            yield Shape("Polygon", (ring,), {})


def _outside(ring: Ring, terrain: Terrain, name: str) -> Shape:
    """Return the map except for a ring."""
    x, y = np.array(ring).T
    west, east = min(0.0, x.min()) - _BEYOND_M, max(terrain.width_m, x.max()) + _BEYOND_M
    south, north = min(0.0, y.min()) - _BEYOND_M, max(terrain.height_m, y.max()) + _BEYOND_M
    around = ((west, south), (east, south), (east, north), (west, north))
    return Shape("Polygon", (around, ring), {"name": name})


def _local(places: Any, terrain: Terrain) -> Ring:
    """Return latitudes and longitudes of the file as local x, y."""
    lat, lon = rows(places, 2).T
    if (abs(lon) > 180).any():
        raise ValueError
    x, y = terrain.to_local(lat, lon)
    return tuple(zip(x.tolist(), y.tolist(), strict=True))
