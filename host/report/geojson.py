"""Paths as GeoJSON."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.files.output import reading
from pathgene.host.inputs import parse_json, read_text
from pathgene.host.numeric import rows
from pathgene.host.problem.ends import Point
from pathgene.host.problem.rings import Ring
from pathgene.host.problem.zones import Zone
from pathgene.host.report.marks import mark_names


if TYPE_CHECKING:
    from pathgene.host.evaluation import SmoothedTrack
    from pathgene.host.terrain import Terrain

__all__ = ["heights_datum", "path_document", "read_path"]

# Nine decimals of a degree are a tenth of a millimetre.
_DEGREE_DECIMALS = 9


def path_document(
    path: NDArray[np.float64],
    track: SmoothedTrack,
    terrain: Terrain,
    step_m: float,
    zones: Sequence[Zone] = (),
    way: Sequence[Point] | None = None,
) -> dict[str, Any]:
    """Return a FeatureCollection: waypoints and smoothed track, the marks, and the zones.

    The first two features are LineStrings. The marks are Points with a ``name``, in the order of
    the flight: start, via points, goal, and the start again after a return. A circular zone is a
    Point with the property ``radius_m``, as :func:`pathgene.host.problem.zones.read_zones` reads
    it.

    Parameters
    ----------
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    track : SmoothedTrack
        The same path, smoothed.
    terrain : Terrain
        Positions are WGS84 longitude, latitude and altitude where it has a CRS; else they are local
        metres, and the member ``crs_local`` is true.
    step_m : float
        Most metres between points of the track.
    zones : sequence of Zone
        No-fly zones.
    way : sequence of (float, float, float), optional
        All points of the mission in order; by default the ends of the path.
    """
    samples = track.sample(step_m)
    smooth = np.stack((samples.x, samples.y, samples.z), axis=1)
    document: dict[str, Any] = {"type": "FeatureCollection"}
    if terrain.crs is None:
        document["crs_local"] = True
    document["heights"] = heights_datum(terrain)
    corners, flown = _positions(path, terrain), _positions(smooth, terrain)
    document["features"] = [
        _feature("LineString", corners, {"kind": "waypoints"}),
        _feature("LineString", flown, {"kind": "smoothed track", "length_m": track.length_m}),
        *_marks(path[[0, -1]].tolist() if way is None else way, terrain),
        *_zones(zones, terrain),
    ]
    return document


def _marks(way: Sequence[Point], terrain: Terrain) -> Iterator[dict[str, Any]]:
    """Yield the points of a mission as features."""
    places = _positions(np.array(way, dtype=np.float64), terrain)
    for name, place in zip(mark_names(way), places, strict=True):
        yield _feature("Point", place, {"kind": name.split()[0].lower(), "name": name})


def heights_datum(terrain: Terrain) -> str:
    """Return what the altitudes of a terrain, and of paths over it, are measured from."""
    system = re.search(r'VERT(?:_CS|CRS)\["([^"]+)"', terrain.crs or "")
    if system:
        return f"AMSL ({system.group(1)})"
    if "SRTM" in terrain.source or terrain.source.lower().endswith(".hgt"):
        return "AMSL (EGM96, the geoid of SRTM)"
    return f"AMSL (the datum of the terrain {terrain.name!r}, which its file does not name)"


def _zones(zones: Sequence[Zone], terrain: Terrain) -> Iterator[dict[str, Any]]:
    """Yield zones as features; their positions are moved all at once, each call takes a while."""
    rings = [ring for zone in zones for ring in _rings(zone)]
    corners = np.array([corner for ring in rings for corner in ring]).reshape(-1, 2)
    positions = iter(_positions(corners, terrain))
    for zone in zones:
        placed = [list(islice(positions, len(ring))) for ring in _rings(zone)]
        properties = {"kind": "zone", **zone.limits}
        if zone.footprint.disc is None:
            yield _feature("Polygon", placed, properties)
        else:
            yield _feature("Point", placed[0][0], properties | {"radius_m": zone.footprint.disc[2]})


def _rings(zone: Zone) -> Sequence[Ring]:
    """Return the closed rings of a zone, or the centre of a circle, metres."""
    if zone.footprint.disc is not None:
        return [(zone.footprint.disc[:2],)]
    return [(*ring, ring[0]) for ring in zone.footprint.wound_rings]


def _positions(points: NDArray[np.float64], terrain: Terrain) -> list[list[float]]:
    """Return points (n, 2 or 3) as positions of GeoJSON."""
    if terrain.crs is None:
        plain: list[list[float]] = points.tolist()
        return plain
    latitude, longitude = terrain.to_geographic(points[:, 0], points[:, 1])
    return [
        [round(east, _DEGREE_DECIMALS), round(north, _DEGREE_DECIMALS), *rest]
        for east, north, rest in zip(
            longitude.tolist(), latitude.tolist(), points[:, 2:].tolist(), strict=True
        )
    ]


def _feature(kind: str, coordinates: Any, properties: dict[str, Any]) -> dict[str, Any]:
    return {
        "type": "Feature",
        "properties": properties,
        "geometry": {"type": kind, "coordinates": coordinates},
    }


def read_path(file: Path, terrain: Terrain) -> NDArray[np.float64]:
    """Return the first LineString of a GeoJSON file as waypoints, (n, 3) float64 metres.

    Raises
    ------
    InputError
        If the file cannot be read, has no LineString with altitudes, or its positions are
        geographic and the terrain has no CRS.
    """
    try:
        with reading("path", file):
            document = parse_json(read_text(file))
    except ValueError:
        raise InputError(f"{file}: not JSON; give GeoJSON, a CSV or a summary.") from None
    positions = _first_line(document)
    if positions is None:
        raise InputError(
            f"{file}: there is no LineString in it to take as the path; give GeoJSON with one, a "
            "CSV or a summary."
        )
    try:
        points = rows(positions, 3)
    except ValueError:
        points = np.empty(0)
    if len(points) < 2:
        raise InputError(
            f"{file}: the LineString must have two or more positions of three numbers "
            "each, the third the altitude."
        )
    if document.get("crs_local") is True:
        return points
    if terrain.crs is None:
        raise InputError(
            f"{file}: its positions are geographic, which a terrain without a "
            "coordinate reference system cannot place; give local metres with "
            '"crs_local": true.'
        )
    x, y = terrain.to_local(points[:, 1], points[:, 0])
    return np.stack((x, y, points[:, 2]), axis=1)


def _first_line(document: Any) -> Any:
    """Return the coordinates of the first LineString in a collection, a feature or a geometry."""
    if not isinstance(document, dict):
        return None
    if document.get("type") == "LineString":
        return document.get("coordinates")
    features = document.get("features")
    for feature in features if isinstance(features, list) else [document]:
        geometry = feature.get("geometry") if isinstance(feature, dict) else None
        if isinstance(geometry, dict) and geometry.get("type") == "LineString":
            return geometry.get("coordinates")
    return None
