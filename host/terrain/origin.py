"""A place on Earth for a terrain whose file has none."""

from __future__ import annotations

import math

from pathgene.host.errors import InputError
from pathgene.host.terrain.grid import Terrain
from pathgene.host.terrain.reading import complete
from pathgene.host.terrain.stated import NO_WATER
from pathgene.host.terrain.water import under_water


__all__ = ["at_origin"]

# Width east of the origin over which metres differ by 0.05 %.
_WIDEST_KM = 200


def at_origin(terrain: Terrain, lat: float, lon: float) -> Terrain:
    """Return the terrain with its south-west node at a point in degrees and its y axis northward.

    Parameters
    ----------
    terrain : Terrain
        A terrain without a coordinate reference system.
    lat, lon : float
        WGS84 latitude, -90 to 90, and longitude, -180 to 180.

    Raises
    ------
    InputError
        If a value is out of range, the terrain already has a place on Earth, or it is so large that
        its metres are not true metres there.
    """
    for name, value, most in (("latitude", lat, 90), ("longitude", lon, 180)):
        if not (math.isfinite(value) and abs(value) <= most):
            raise InputError(
                f"The {name} of the origin must be from -{most} to {most} degrees, "
                f"not {value:g}; latitude comes first (--origin LAT,LON, or origin under "
                "[terrain] in a problem file)."
            )
    if terrain.crs is not None:
        raise InputError(
            f"The terrain {terrain.name!r} states its place on Earth; leave the origin out "
            "(--origin, or origin under [terrain] in a problem file)."
        )
    # Loads GDAL, which terrains in local metres do not need.
    from pathgene.host.terrain.geodesy import local_crs

    placed = terrain.having(crs=local_crs(float(lat), float(lon)), origin=(0.0, 0.0))
    assert placed.metric is not None
    if not placed.metric.is_metric:
        raise InputError(
            f"The terrain {terrain.name!r} is {1e-3 * terrain.width_m:.0f} x "
            f"{1e-3 * terrain.height_m:.0f} km large, and its metres differ from true metres by "
            f"{placed.metric.spread:.2%} east of its origin; cut out the part you need, at most "
            f"{_WIDEST_KM:g} km from west to east."
        )
    level = terrain.loading.get("water_level")
    if level is None and terrain.reading.facts.get("is_own"):
        level = NO_WATER
    return complete(under_water(placed, level))
