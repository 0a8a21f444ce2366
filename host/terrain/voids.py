"""Voids: nodes without a height, how files mark them, and their interpolation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


__all__ = ["UNDECLARED_VOID", "fill"]

Floats = NDArray[np.float64]

#: SRTM's mark of a void, which remains in files that declare another value or none.
UNDECLARED_VOID = -32768.0


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
