"""Voids: nodes without a height, and their interpolation."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


__all__ = [
    "HIGHEST_M",
    "LOWEST_FLOOR_M",
    "LOWEST_M",
    "UNDECLARED_VOID",
    "fill",
    "from_corner",
    "holds",
    "number",
]

Floats = NDArray[np.float64]

#: SRTM's mark of a void, which remains in files that declare another value or none.
UNDECLARED_VOID = -32768.0
#: Lowest sea floor, lowest dry land and highest ground, metres.
LOWEST_FLOOR_M, LOWEST_M, HIGHEST_M = -11_000.0, -500.0, 9_000.0

# Numbers that differ by this multiple of a type's precision are equal.
_ROUNDING = 4.0


def number(value: float) -> str:
    """Return a number with all its digits, an integer without a decimal point."""
    return repr(float(value)).removesuffix(".0")


def holds(numbers: NDArray[Any], value: float) -> NDArray[np.bool_]:
    """Return the cells that hold a number, within the rounding of their type."""
    if numbers.dtype.kind != "f":
        return np.asarray(numbers == value)
    tolerance = _ROUNDING * np.finfo(numbers.dtype).eps
    return np.asarray(np.isclose(numbers, value, rtol=tolerance, atol=0.0))


def from_corner(east_m: float, north_m: float) -> str:
    """Describe a place in a terrain in words, to a decimetre."""
    east, north = number(round(east_m, 1)), number(round(north_m, 1))
    return f"{east} m east and {north} m north of the south-west node"


def fill(heights: Floats) -> Floats:
    """Interpolate voids from the heights around them, searching as far as the larger side."""
    known = ~np.isnan(heights)
    if known.all():
        return heights
    from rasterio.fill import fillnodata

    # GDAL fills in single precision; known heights stay unchanged.
    filled = fillnodata(
        heights.astype(np.float32),
        mask=known.astype(np.uint8),
        max_search_distance=float(max(heights.shape)),
        smoothing_iterations=0,
    )
    return np.where(known, heights, filled.astype(np.float64))
