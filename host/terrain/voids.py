"""Voids: nodes without a height, how files mark them, and their interpolation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError


__all__ = [
    "HIGHEST_M",
    "LOWEST_M",
    "UNDECLARED_VOID",
    "fill",
    "from_corner",
    "number",
    "require_heights",
]

Floats = NDArray[np.float64]

#: SRTM's mark of a void, which remains in files that declare another value or none.
UNDECLARED_VOID = -32768.0
#: Lowest and highest height of the ground, metres; a number outside is a mark or in another unit.
LOWEST_M, HIGHEST_M = -500.0, 9_000.0


def require_heights(
    name: str, heights: Floats, place: Callable[[int, int], str], remedy: Callable[[float], str]
) -> None:
    """Check that all heights can be ground, so that no mark of a void is mistaken for a pit.

    Call it before heights are interpolated, because interpolation could bring a mark into the
    range.

    Parameters
    ----------
    name : str
        Name of the terrain in the sentence.
    heights : ndarray
        ``(rows, columns)`` float64 metres; NaN is a void.
    place : callable
        Takes row and column of a node and returns its place, in words.
    remedy : callable
        Takes the height of the node and returns advice for the user, in words.

    Raises
    ------
    InputError
        If a height lies outside :data:`LOWEST_M` to :data:`HIGHEST_M`.
    """
    # No temporary array in the usual case; `fmin` and `fmax` ignore voids.
    low, high = np.fmin.reduce(heights, axis=None), np.fmax.reduce(heights, axis=None)
    if not (low < LOWEST_M or high > HIGHEST_M):
        return
    outside = np.argwhere((heights < LOWEST_M) | (heights > HIGHEST_M))
    row, column = map(int, outside[0])
    height = float(heights[row, column])
    raise InputError(
        f"{name}: {len(outside):,} of {heights.size:,} heights lie outside {LOWEST_M:g} to "
        f"{HIGHEST_M:,g} m; the first, {place(row, column)}, is {number(height)} m, probably a "
        f"void mark that is not declared, or no height in metres: {remedy(height)}."
    )


def number(value: float) -> str:
    """Return a number with all its digits, an integer without a decimal point."""
    return repr(float(value)).removesuffix(".0")


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
