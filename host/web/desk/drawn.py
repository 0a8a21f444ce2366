"""A problem as the views draw it, even if it is still incomplete or invalid."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.mission.build import zones_of
from pathgene.host.problem.tiles import over_ground
from pathgene.host.problem.zones import Zone
from pathgene.host.terrain import Terrain
from pathgene.host.web.desk.sheet import Sheet
from pathgene.host.web.scene import zones_scene


__all__ = ["drawn_problem"]


def drawn_problem(sheet: Sheet, terrain: Terrain) -> dict[str, Any]:
    """Return ``points`` and ``zones`` of a problem as in a scene, including invalid ones."""
    zones = over_ground([_zone(table, terrain) for table in sheet.zones], terrain)
    return {"points": list(_points(sheet, terrain)), "zones": zones_scene(zones), "ceilings": []}


def _points(sheet: Sheet, terrain: Terrain) -> Iterator[dict[str, Any]]:
    values = sheet.values
    via = [("via", f"Via {number}", point) for number, point in enumerate(sheet.via, start=1)]
    ends = [(end, end.capitalize(), values.get(end)) for end in ("start", "goal")]
    back = [("return", "Return", values.get("start"))] if values.get("return_to_start") else []
    for kind, name, point in (ends[0], *via, ends[1], *back):
        if point is None:
            continue
        x, y, z = point
        ground = float(terrain.ground(x, y))
        below = ground if math.isfinite(ground) else None
        altitude = z + (below or 0.0) if values.get("agl") else z
        yield {"kind": kind, "name": name, "x": x, "y": y, "z": altitude, "ground_m": below}


def _zone(table: Mapping[str, Any], terrain: Terrain) -> Zone:
    """Return a zone, without its limits if these are invalid."""
    try:
        return zones_of({"zones": [table]}, terrain)[0]
    except InputError:
        shape = {key: table[key] for key in ("circle", "polygon", "holes") if key in table}
        return zones_of({"zones": [shape]}, terrain)[0]
