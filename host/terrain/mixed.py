"""Heights beside voids into which resampling has mixed the mark of the voids."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.remarks import Reading
from pathgene.host.terrain.file_heights import FileHeights, neighbours
from pathgene.host.terrain.gaps import STEEPEST
from pathgene.host.terrain.voids import number


__all__ = ["require_unmixed"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# Lowest step from a cell beside a void to the ground farther away, metres; STEEPEST in larger
# cells.
_STEP_M = 100.0
# Minimum number of mixed cells, and their minimum share of the cells beside voids. On six
# real maps in up to 16 times coarser cells, with real and made voids, 0.2 % or a single
# cell are so low.
_FEWEST_CELLS, _SHARE = 4, 0.05
# Resampling mixes one mark into the ground: steps of the opposite sign are at most this share.
_OTHER_WAY = 0.25
# Steps as high are at least this many times rarer away from voids.
_RARER = 4.0


def require_unmixed(file: FileHeights, heights: Floats, reading: Reading) -> None:
    """Check that the heights beside voids are not partly a mark of voids.

    Such a cell lies a high step below, or above, all ground that is farther from the void, and no
    ground of its own height leads away from it, as it does from the bank of a river or the foot of
    a cliff. Land that is as steep elsewhere is left alone.

    Parameters
    ----------
    file : FileHeights
        Name, places and numbers for messages.
    heights : ndarray
        ``(rows, columns)`` float64 metres, without marks; NaN is a void.
    reading : Reading
        The facts of the file, with its marks.

    Raises
    ------
    InputError
        If 4 cells and 5 % of the cells beside voids are so.
    """
    step_m = max(_STEP_M, STEEPEST * file.cell_m)
    low, high = np.fmin.reduce(heights, axis=None), np.fmax.reduce(heights, axis=None)
    if not high - low > step_m:
        return
    voids = np.isnan(heights)
    if not voids.any():
        return
    # Loads SciPy, which maps without voids do not need.
    from scipy.ndimage import binary_dilation

    beside = binary_dilation(voids, np.ones((3, 3))) & ~voids
    pits, count = _pits(heights, voids, beside, step_m)
    peaks, _ = _pits(-heights, voids, beside, step_m)
    few, many = sorted((pits, peaks), key=np.count_nonzero)
    mixed = int(many.sum())
    if mixed < max(_FEWEST_CELLS, _SHARE * count) or few.sum() > _OTHER_WAY * mixed:
        return
    if mixed < _RARER * count * _steep_share(heights, beside, step_m):
        return
    where = "below" if many is pits else "above"
    raise InputError(
        f"{file.name}: resampling has mixed a mark of voids into {mixed:,} heights: they lie "
        f"beside voids, {step_m:.0f} m and more {where} all ground farther away, the first "
        f"{file.place_of_first(many)}; resample again from the original with gdalwarp -srcnodata "
        f"{_mark(reading)}, or accept all numbers as heights (--void none)."
    )


def _mark(reading: Reading) -> str:
    """Return the mark of a file's voids for a command."""
    declared = reading.facts.get("declared_void")
    if declared is not None:
        return number(declared)
    marks = [*reading.facts.get("marks", ()), *(reading.facts.get("named_void") or ())]
    return number(marks[0]["value"]) if marks else "MARK"


def _steep_share(heights: Floats, beside: Bools, step_m: float) -> float:
    """Return the share of high steps between neighbours that are not beside voids."""
    steep = steps = 0
    for (first, second), (is_first, is_second) in zip(
        neighbours(heights), neighbours(beside), strict=True
    ):
        rises = np.abs(second - first)[~is_first & ~is_second]
        steps += int(np.count_nonzero(~np.isnan(rises)))
        steep += int(np.count_nonzero(rises > step_m))
    return steep / max(1, steps)


def _pits(heights: Floats, voids: Bools, beside: Bools, step_m: float) -> tuple[Bools, int]:
    """Return cells beside voids below all other ground, and the number of cells with such ground.

    Parameters
    ----------
    beside : ndarray of bool
        The cells beside voids.
    step_m : float
        Lowest step to the ground.
    """
    from scipy.ndimage import label

    rises = np.full(heights.shape, np.inf)
    places = zip(neighbours(heights), neighbours(beside), neighbours(rises), strict=True)
    for (first, second), (is_first, is_second), (of_first, of_second) in places:
        inward = is_first & ~is_second & ~np.isnan(second)
        of_first[inward] = np.minimum(of_first[inward], second[inward] - first[inward])
        inward = is_second & ~is_first & ~np.isnan(first)
        of_second[inward] = np.minimum(of_second[inward], first[inward] - second[inward])
    known = np.isfinite(rises)
    low = known & (rises > step_m)
    if not low.any():
        return low, int(known.sum())
    leads_away = ~voids & ~low & (~beside | (rises <= 0.5 * step_m))
    areas, count = label(low, np.ones((3, 3)))
    joined = np.zeros(count + 1, dtype=bool)
    for edge in (areas[0], areas[-1], areas[:, 0], areas[:, -1]):
        joined[edge] = True
    for (first, second), (area, other), (away_first, away_second) in zip(
        neighbours(heights), neighbours(areas), neighbours(leads_away), strict=True
    ):
        with np.errstate(invalid="ignore"):
            is_level = np.abs(first - second) <= 0.5 * step_m
        joined[area[(area > 0) & away_second & is_level]] = True
        joined[other[(other > 0) & away_first & is_level]] = True
    joined[0] = True
    return ~joined[areas], int(known.sum())
