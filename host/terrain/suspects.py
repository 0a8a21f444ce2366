"""Heights that ground may have, but that look like voids or like another unit."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pathgene.host.remarks import Grade, Remark
from pathgene.host.terrain.file_heights import FileHeights, neighbours
from pathgene.host.terrain.gaps import STEEPEST
from pathgene.host.terrain.stated import HEIGHT_UNITS


__all__ = ["suspicions"]

Floats = NDArray[np.float64]

# Lowest step up from an area of zeros that no coast has all around, metres; STEEPEST in larger
# cells. The lowest shore of each part of Jervis Inlet, a fjord, is at most a fifth of this.
_SHORE_M = 100.0
# A quarter of the slopes between neighbours is not steeper than this on any land. On six real maps,
# the steepest quarter begins at 0.2 to 0.52.
_QUARTER, _STEEP = 0.25, 1.0
# Smallest cell, metres, and fewest steps for which that is known: walls of buildings are steep.
_SMALLEST_M, _FEWEST_STEPS = 10.0, 100
# Steps that are examined.
_SAMPLE_STEPS = 1_000_000


def suspicions(file: FileHeights, heights: Floats, *, is_unit_known: bool) -> Iterator[Remark]:
    """Yield warnings of zeros amid higher land, and of heights too steep for metres.

    Parameters
    ----------
    file : FileHeights
        Name, places and numbers for messages.
    heights : ndarray
        ``(rows, columns)`` float64 metres, without marks; NaN is a void.
    is_unit_known : bool
        The file or the user states the unit of the heights, or the file a scale.
    """
    yield from _zeros(file, heights)
    if not is_unit_known:
        yield from _steepness(file, heights)


def _zeros(file: FileHeights, heights: Floats) -> Iterator[Remark]:
    zeros = heights == file.zero_m
    if not zeros.any():
        return
    # Loads SciPy, which most maps do not need.
    from scipy.ndimage import label

    areas, count = label(zeros, np.ones((3, 3)))
    shores = np.full(count + 1, np.inf)
    for (first, second), (area, other) in zip(neighbours(heights), neighbours(areas), strict=True):
        for inner, outer, outside in ((area, other, second), (other, area, first)):
            shore = (inner > 0) & (outer == 0) & ~np.isnan(outside)
            np.minimum.at(shores, inner[shore], outside[shore] - file.zero_m)
    high = np.isfinite(shores) & (shores > max(_SHORE_M, STEEPEST * file.cell_m))
    if not high.any():
        return
    cells = high[areas]
    number = int(cells.sum())
    hold = "cells hold" if number > 1 else "cell holds"
    yield Remark(
        Grade.WARNING,
        f"{number:,} {hold} 0 amid heights of {shores[high].min() + file.zero_m:.0f} m and more, "
        f"the first {file.place_of_first(cells)}; this looks like voids without a mark: give "
        "--void 0 if so, or --void none if it is ground.",
    )


def _steepness(file: FileHeights, heights: Floats) -> Iterator[Remark]:
    if file.cell_m < _SMALLEST_M:
        return
    every = max(1, 2 * heights.size // _SAMPLE_STEPS)
    rows, columns = heights[::every], heights[:, ::every]
    steps = np.concatenate(
        [np.abs(np.diff(rows)).ravel(), np.abs(np.diff(columns, axis=0)).ravel()]
    )
    steps = steps[~np.isnan(steps)]
    if len(steps) < _FEWEST_STEPS:
        return
    if np.quantile(steps, 1 - _QUARTER) <= _STEEP * file.cell_m:
        return
    known = rows[~np.isnan(rows)]
    if (known != np.rint(known)).any():
        return
    degrees = math.degrees(math.atan(_STEEP))
    yield Remark(
        Grade.WARNING,
        f"More than a quarter of the slopes between neighbouring cells are steeper than "
        f"{degrees:.0f} degrees, as on no land; the whole numbers look like decimetres, "
        f"centimetres or feet: state their unit (--height-unit {'|'.join(HEIGHT_UNITS)}).",
    )
