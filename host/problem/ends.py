"""Points that a user gives, as x, y and altitude; usual mistakes get a sentence with a remedy.

The usual mistakes are longitude before latitude, eastings and northings instead of local metres,
and heights above the ground instead of altitudes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from pathgene.host.errors import InputError
from pathgene.host.numeric import numbers
from pathgene.host.terrain import Terrain


__all__ = ["Point", "check_above_ground", "end_point", "finite", "place"]

Point = tuple[float, float, float]

#: Up to this altitude, a point in the ground may be meant as a height above it.
_LIKELY_HEIGHT_M = 1000.0


def end_point(
    name: str,
    values: Sequence[float],
    terrain: Terrain,
    *,
    agl: bool = False,
    geo: bool = False,
) -> Point:
    """Return a point as x, y and altitude.

    Parameters
    ----------
    name : str
        Name of the point in sentences, ``start`` for example.
    values : sequence of float
        Its three numbers.
    terrain : Terrain
        The ground.
    agl : bool
        The third number is a height above the ground.
    geo : bool
        The first two numbers are WGS84 latitude and longitude in degrees.

    Raises
    ------
    InputError
        If they are not three finite numbers; with ``agl``, if they lie off the map or over a void;
        with ``geo``, if the terrain has no reference system.
    """
    x, y, z = finite(name, values, 3)
    if geo:
        x, y = place(name, x, y, terrain)
    if agl:
        z += _ground(name, terrain, x, y)
    return x, y, z


def place(name: str, latitude: float, longitude: float, terrain: Terrain) -> tuple[float, float]:
    """Return x and y of a point in WGS84 degrees.

    Raises
    ------
    InputError
        If the terrain has no reference system, or the degrees look swapped.
    """
    if terrain.crs is not None and abs(latitude) > 90:
        raise InputError(
            f"The {name} has the latitude {latitude:g}, which must be from -90 to 90 degrees: "
            "latitude first?"
        )
    x, y = terrain.to_local(latitude, longitude)
    if not _is_on_map(terrain, x, y) and abs(longitude) <= 90:
        try:
            swapped = terrain.to_local(longitude, latitude)
        except InputError:
            return float(x), float(y)
        if _is_on_map(terrain, *swapped):
            raise InputError(
                f"The {name} at latitude {latitude:g} and longitude {longitude:g} is outside the "
                "map, but on it with the two swapped: latitude first?"
            )
    return float(x), float(y)


def check_above_ground(name: str, terrain: Terrain, point: Point) -> None:
    """Check that a point is on the map, not over a void and not in the ground.

    Raises
    ------
    InputError
        If it is not.
    """
    x, y, z = point
    ground = _ground(name, terrain, x, y)
    if z < ground:
        remedy = "raise it"
        if 0 <= z <= _LIKELY_HEIGHT_M:
            remedy += f", or give --agl if {z:g} m is its height above the ground"
        raise InputError(
            f"The {name} at an altitude of {z:g} m is inside the ground, which is "
            f"at {ground:g} m there; {remedy}."
        )


def finite(name: str, values: Sequence[float], count: int) -> tuple[float, ...]:
    """Return ``values`` as a tuple of ``count`` finite floats.

    Raises
    ------
    InputError
        If they are something else.
    """
    try:
        return numbers(values, count)
    except ValueError:
        raise InputError(f"The {name} must be {count} finite numbers, not {values!r}.") from None


def _ground(name: str, terrain: Terrain, x: float, y: float) -> float:
    """Return the height of the ground; refuse a point off the map or over a void."""
    if not _is_on_map(terrain, x, y):
        raise InputError(
            f"The {name} at ({x:.10g}, {y:.10g}) is outside the map, which reaches from "
            f"(0, 0) to ({terrain.width_m:g}, {terrain.height_m:g}) m{_local_hint(terrain, x, y)}."
        )
    ground = float(terrain.elevation[terrain.nearest_node(x, y)])
    if math.isnan(ground):
        raise InputError(
            f"The {name} at ({x:g}, {y:g}) is over a void of the terrain; move it, or "
            f"fill the voids (--fill-voids)."
        )
    return ground


def _is_on_map(terrain: Terrain, x: float, y: float) -> bool:
    return 0 <= x <= terrain.width_m and 0 <= y <= terrain.height_m


def _local_hint(terrain: Terrain, x: float, y: float) -> str:
    """Return the local metres of a point that is on the map as an easting and a northing."""
    if terrain.crs is None or terrain.origin is None:
        return ""
    east, north = terrain.frame.from_grid(x, y)
    if not _is_on_map(terrain, east, north):
        return ""
    return (
        f"; as easting and northing in {_short(terrain.crs)} it is on the map, so give its local "
        f"metres, {east:.2f},{north:.2f}"
    )


def _short(crs: str) -> str:
    return crs if len(crs) < 20 else "the terrain's reference system"
