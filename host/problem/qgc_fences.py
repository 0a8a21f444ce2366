"""Fences of a ``.plan`` of QGroundControl, in metres of a terrain's local frame."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from pathgene.host.errors import InputError
from pathgene.host.numeric import as_number, rows
from pathgene.host.problem.geojson import Shape
from pathgene.host.problem.rings import Ring
from pathgene.host.terrain import Terrain


__all__ = ["fence_shapes"]

# A fence to stay in becomes a zone around it that reaches so far beyond the map and the fence.
_BEYOND_M = 1000.0
# Corners of the polygon inside a circle to stay in.
_CIRCLE_CORNERS = 180


def fence_shapes(document: dict[str, Any], terrain: Terrain) -> Iterator[Shape]:
    """Yield the fences of a plan as zones.

    A fence to keep out of is the circle or polygon itself. One to stay in is the rest of the map: a
    rectangle with the fence as its hole, for each such fence, so that a path keeps within all of
    them. A circle to stay in is a polygon of 180 corners on it.

    Raises
    ------
    InputError
        If the fences are of another version, one is bad, there is none, or the terrain has no place
        on Earth.
    """
    try:
        fences = document["geoFence"]
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
    """Return all of the map but a ring."""
    x, y = np.array(ring).T
    west, east = min(0.0, x.min()) - _BEYOND_M, max(terrain.width_m, x.max()) + _BEYOND_M
    south, north = min(0.0, y.min()) - _BEYOND_M, max(terrain.height_m, y.max()) + _BEYOND_M
    around = ((west, south), (east, south), (east, north), (west, north))
    return Shape("Polygon", (around, ring), {"name": name})


def _local(places: Any, terrain: Terrain) -> Ring:
    """Latitudes and longitudes of the file as local x, y."""
    lat, lon = rows(places, 2).T
    if (abs(lon) > 180).any():
        raise ValueError
    x, y = terrain.to_local(lat, lon)
    return tuple(zip(x.tolist(), y.tolist(), strict=True))
