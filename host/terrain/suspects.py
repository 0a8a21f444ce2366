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
from pathgene.host.terrain.voids import number


__all__ = ["suspicions"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# Lowest step up from an area of one number that no coast has all around, metres; STEEPEST in larger
# cells. The lowest shore of each part of Jervis Inlet, a fjord, is at most a fifth of this.
_SHORE_M = 100.0
# Numbers that are examined besides 0, and fewest cells that hold one: a single low cell is an error
# of a height.
_MOST_NUMBERS, _FEWEST_CELLS = 8, 4
# A quarter of the slopes between neighbours is not steeper than this on any land. On six real maps,
# the steepest quarter begins at 0.2 to 0.52.
_QUARTER, _STEEP = 0.25, 1.0
# Smallest cell, metres, and fewest steps for which that is known: walls of buildings are steep.
_SMALLEST_M, _FEWEST_STEPS = 10.0, 100
# Steps that are examined.
_SAMPLE_STEPS = 1_000_000
# Cells whose steps are computed at a time.
_BLOCK_CELLS = 100_000


def suspicions(file: FileHeights, heights: Floats, *, is_unit_known: bool) -> Iterator[Remark]:
    """Yield warnings of one number amid higher land, and of heights too steep for metres.

    Parameters
    ----------
    file : FileHeights
        Name, places and numbers for messages.
    heights : ndarray
        ``(rows, columns)`` float64 metres, without marks; NaN is a void.
    is_unit_known : bool
        The file or the user states the unit of the heights, or the file a scale.
    """
    yield from _repeated(file, heights)
    if not is_unit_known:
        yield from _steepness(file, heights)


def _repeated(file: FileHeights, heights: Floats) -> Iterator[Remark]:
    """Yield a warning for each number whose areas lie below all heights next to them."""
    shore_m = max(_SHORE_M, STEEPEST * file.cell_m)
    for value in _at_feet(file, heights, shore_m):
        found = _amid_land(heights, heights == value, value, shore_m)
        if found is None:
            continue
        cells, lowest = found
        count = int(cells.sum())
        if count < _FEWEST_CELLS and value != file.zero_m:
            continue
        hold = "cells hold" if count > 1 else "cell holds"
        text = "0" if value == file.zero_m else number(file.in_file(value))
        yield Remark(
            Grade.WARNING,
            f"{count:,} {hold} {text} amid heights of {lowest:.0f} m and more, "
            f"the first {file.place_of_first(cells)}; this looks like voids without a mark: give "
            f"--void {text} if so, or --void none if it is ground.",
        )


def _at_feet(file: FileHeights, heights: Floats, step_m: float) -> list[float]:
    """Return the number 0 and the most common heights at the foot of a high step, if any."""
    low, high = np.fmin.reduce(heights, axis=None), np.fmax.reduce(heights, axis=None)
    if not high - low > step_m:
        return []
    feet = []
    with np.errstate(invalid="ignore"):
        for ones, others in neighbours(heights):
            # Some rows at a time, whose differences fit into a processor's cache.
            rows = max(_BLOCK_CELLS // heights.shape[1], 1)
            for at in range(0, len(ones), rows):
                first, second = ones[at : at + rows], others[at : at + rows]
                rise = second - first
                for foot, is_foot in ((first, rise > step_m), (second, rise < -step_m)):
                    if is_foot.any():
                        feet.append(foot[is_foot])
    if not feet:
        return []
    values, counts = np.unique(np.concatenate(feet), return_counts=True)
    commonest: list[float] = values[np.argsort(-counts, kind="stable")[:_MOST_NUMBERS]].tolist()
    if file.zero_m in values and file.zero_m not in commonest:
        commonest.append(file.zero_m)
    return sorted(commonest)


def _amid_land(
    heights: Floats, held: Bools, value: float, shore_m: float
) -> tuple[Bools, float] | None:
    """Return the cells of areas that lie ``shore_m`` below all around, and the lowest shore."""
    # Loads SciPy, which most maps do not need.
    from scipy.ndimage import label

    areas, count = label(held, np.ones((3, 3)))
    shores = np.full(count + 1, np.inf)
    for (first, second), (area, other) in zip(neighbours(heights), neighbours(areas), strict=True):
        for inner, outer, outside in ((area, other, second), (other, area, first)):
            shore = (inner > 0) & (outer == 0) & ~np.isnan(outside)
            np.minimum.at(shores, inner[shore], outside[shore])
    high = np.isfinite(shores) & (shores - value > shore_m)
    return (high[areas], float(shores[high].min())) if high.any() else None


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
