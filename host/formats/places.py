"""Places on Earth, as written to files."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.terrain import Terrain


__all__ = ["DEGREE_DECIMALS", "check_place", "degrees", "number_text"]

#: Decimals of a degree in files: nine are a tenth of a millimetre.
DEGREE_DECIMALS = 9


def check_place(terrain: Terrain) -> None:
    """Refuse a terrain that has no place on Earth.

    Raises
    ------
    InputError
        If it has none.
    """
    if terrain.crs is None or terrain.origin is None:
        raise InputError(
            f"The terrain {terrain.name!r} has no place on Earth, which this file needs; give the "
            "latitude and longitude of its south-west node (--origin LAT,LON, or origin under "
            "[terrain] in a problem file)."
        )


def degrees(
    terrain: Terrain, x: NDArray[np.float64], y: NDArray[np.float64]
) -> tuple[tuple[float, float], ...]:
    """Return (latitude, longitude) of points in local metres, rounded as in every file."""
    lat, lon = terrain.to_geographic(x, y)
    return tuple(
        (round(north, DEGREE_DECIMALS), round(east, DEGREE_DECIMALS))
        for north, east in zip(lat.tolist(), lon.tolist(), strict=True)
    )


def number_text(value: float) -> str:
    """Return a number in full and without an exponent."""
    return np.format_float_positional(value, trim="-")
