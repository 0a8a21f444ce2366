"""Heights far from all other heights of a map, with no ground between."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pathgene.host.terrain.file_heights import neighbours


__all__ = ["GAP_M", "STEEPEST", "Group", "far_groups", "joins"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: A value farther than this from all other values may not be ground, metres.
GAP_M = 1_000.0
#: Steepest slope of a step between neighbours that ground may have all around an area. The steepest
#: single step on six real maps has a slope of 1.8 in cells of 240 m, and of 1.0 in cells of 1 km.
STEEPEST = 1.5
# Share of the steps around an area that must be steeper.
_MOST_STEPS = 0.75
# Across voids, steps from the nearest heights up to this multiple of the least distance count.
_NEAR = 2.0
# Width of a class of heights, metres, and number of cells counted at a time.
_CLASS_M = 100.0
_BLOCK_CELLS = 1 << 22
# Cells that are examined first.
_SAMPLE_CELLS = 100_000


@dataclass(frozen=True)
class Group:
    """Heights that are more than 1,000 m from all other heights.

    Parameters
    ----------
    bottom, top : float
        The lowest and the highest, metres.
    cells : int
        Number of cells that hold them.
    """

    bottom: float
    top: float
    cells: int

    @property
    def is_one_value(self) -> bool:
        """All cells hold the same height."""
        return self.bottom == self.top

    def mask(self, heights: Floats) -> Bools:
        """Return the cells that hold them."""
        with np.errstate(invalid="ignore"):
            inside: Bools = (heights >= self.bottom) & (heights <= self.top)
        return inside


def far_groups(heights: Floats) -> list[Group]:
    """Return the heights far from all other heights, except the largest group, from low to high.

    The largest group is the ground. A single value is the ground only if all groups are single
    values, because it may be the mark of many voids.
    """
    low, high = np.fmin.reduce(heights, axis=None), np.fmax.reduce(heights, axis=None)
    if not high - low > GAP_M:
        return []
    # A gap of all heights is also a gap of some of them, which take a hundredth of the time.
    every = max(1, int(math.sqrt(heights.size / _SAMPLE_CELLS)))
    sampled = _classes(heights[::every, ::every], low, high)
    sampled[[0, -1]] = 1
    if np.diff(np.flatnonzero(sampled)).max() < GAP_M / _CLASS_M:
        return []
    held = np.flatnonzero(_classes(heights, low, high))
    ends = np.flatnonzero(np.diff(held) >= GAP_M / _CLASS_M)
    groups: list[Group] = []
    for first, last in zip(
        held[np.r_[0, ends + 1]].tolist(), held[np.r_[ends, len(held) - 1]].tolist(), strict=True
    ):
        # Half a class is enough for rounding: the next class with values is nine away.
        bottom, top = low + (first - 0.5) * _CLASS_M, low + (last + 1.5) * _CLASS_M
        inside = heights[(heights >= bottom) & (heights < top)]
        group = Group(float(inside.min()), float(inside.max()), len(inside))
        # Heights in classes that far apart may still be nearer than the gap.
        if groups and not group.bottom - groups[-1].top > GAP_M:
            before = groups.pop()
            group = Group(before.bottom, group.top, before.cells + group.cells)
        groups.append(group)
    ground = max(groups, key=lambda group: (not group.is_one_value, group.cells))
    return [group for group in groups if group is not ground]


def joins(heights: Floats, inside: Bools, cell_m: float) -> bool:
    """Return whether ground may lead from an area to the heights around it, also across voids."""
    steps = steep = 0
    for (first, second), (is_first, is_second) in zip(
        neighbours(heights), neighbours(inside), strict=True
    ):
        border = (is_first != is_second) & ~np.isnan(first) & ~np.isnan(second)
        steps += int(border.sum())
        steep += int((np.abs(first[border] - second[border]) > STEEPEST * cell_m).sum())
    if steps:
        return steep < _MOST_STEPS * steps
    others = ~inside & ~np.isnan(heights)
    if not others.any():
        return True
    # Loads SciPy, which maps without such areas do not need.
    from scipy.ndimage import distance_transform_edt

    far, nearest = distance_transform_edt(~inside, sampling=cell_m, return_indices=True)
    near = others & (far <= _NEAR * far[others].min())
    across = np.abs(heights[near] - heights[nearest[0][near], nearest[1][near]])
    return bool(np.median(across / far[near]) <= STEEPEST)


def _classes(heights: Floats, low: float, high: float) -> NDArray[np.int64]:
    """Return the number of heights in each class from ``low`` to ``high``."""
    classes = np.zeros(int((high - low) / _CLASS_M) + 1, dtype=np.int64)
    rows = max(1, _BLOCK_CELLS // heights.shape[1])
    for start in range(0, len(heights), rows):
        block = heights[start : start + rows]
        numbers = ((block[~np.isnan(block)] - low) / _CLASS_M).astype(np.int64)
        classes += np.bincount(numbers, minlength=len(classes))
    return classes
