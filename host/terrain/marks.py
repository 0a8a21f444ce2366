"""Numbers that are not heights: marks of voids that a file does not declare."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.remarks import Grade, Reading, Remark
from pathgene.host.terrain.voids import HIGHEST_M, LOWEST_M, number


__all__ = ["DEEPEST_M", "Mark", "marked", "without_marks"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
_Kind = TypeVar("_Kind", bound=np.generic)

#: Lowest sea floor, metres.
DEEPEST_M = -11_000.0
#: A value farther than this from all other values is not ground, metres.
_GAP_M = 1_000.0
#: A larger step between neighbours is not ground, metres; in larger cells it is a cell's side.
_STEP_M = 300.0
#: Share of the steps around a value that must be that large.
_MOST_STEPS = 0.75
#: A value in this number of cells or fewer may be an outlier.
_FEW_CELLS = 3
#: Maximum number of different marks in a file.
_MOST_MARKS = 8
# Width of a class of heights, metres, and number of cells counted at a time.
_CLASS_M = 100.0
_BLOCK_CELLS = 1 << 22
# Cells that are examined first.
_SAMPLE_CELLS = 100_000
# Numbers from here on are not a height in any unit.
_NO_HEIGHT = 1e5
# Decimals that single precision cannot represent.
_DIGITS = 6


@dataclass(frozen=True)
class Mark:
    """A number that represents a void.

    Parameters
    ----------
    value : float
        The number in the file.
    cells : int
        Number of cells that hold it.
    """

    value: float
    cells: int

    def to_dict(self) -> dict[str, Any]:
        """The mark as JSON values."""
        return {"value": self.value, "cells": self.cells}


@dataclass(frozen=True)
class _File:
    """Name, places and remedies of a file, for messages about its heights."""

    name: str
    place: Callable[[int, int], str]
    remedy: Callable[[float], str]
    in_file: Callable[[float], float]

    def refusal(self, heights: Floats, bad: Bools, cause: str) -> InputError:
        """Return the refusal of heights, with the first of them."""
        row, column = (int(each) for each in np.unravel_index(int(np.argmax(bad)), bad.shape))
        height = float(heights[row, column])
        return InputError(
            f"{self.name}: {int(bad.sum()):,} of {heights.size:,} heights {cause}; the first, "
            f"{self.place(row, column)}, is {number(height)} m, probably a void mark that is not "
            f"declared, or no height in metres: {self.remedy(height)}."
        )


def without_marks(
    name: str,
    heights: Floats,
    cell_m: float,
    place: Callable[[int, int], str],
    remedy: Callable[[float], str],
    in_file: Callable[[float], float] = float,
    *,
    by_gap: bool = True,
) -> tuple[Floats, tuple[Mark, ...], tuple[str, ...]]:
    """Return heights with NaN for all marks of voids, the marks, and warnings.

    A mark is one number, repeated or of a typical form, that lies outside -11,000 to 9,000 m, or
    below -500 m without joining the heights around it, or more than 1,000 m from all other values.
    Call it before heights are interpolated, which mixes marks with the ground.

    Parameters
    ----------
    name : str
        Name of the terrain in sentences.
    heights : ndarray
        ``(rows, columns)`` float64 metres; NaN is a void.
    cell_m : float
        Longer side of a cell, metres.
    place : callable
        Takes row and column of a node and returns its place, in words.
    remedy : callable
        Takes the height of the node and returns advice for the user, in words.
    in_file : callable
        Takes a height in metres and returns the number in the file.
    by_gap : bool
        Also look for values that are possible heights, far from all other values.

    Raises
    ------
    InputError
        If such numbers are not marks.
    """
    # No array in the usual case; `fmin` and `fmax` ignore voids.
    low, high = np.fmin.reduce(heights, axis=None), np.fmax.reduce(heights, axis=None)
    if low >= LOWEST_M and high <= HIGHEST_M and not (by_gap and high - low > _GAP_M):
        return heights, (), ()
    file = _File(name, place, remedy, in_file)
    marks: list[Mark] = []

    def remove(value: float, cells: Bools) -> None:
        nonlocal heights
        if not marks:
            heights = heights.copy()
        marks.append(Mark(_short(in_file(value)), int(cells.sum())))
        heights[cells] = np.nan

    if low < DEEPEST_M or high > HIGHEST_M:
        for value, cells in list(_beyond_all_ground(file, heights)):
            remove(value, cells)
    if low < LOWEST_M:
        bottom, top = (reduce(heights, axis=None) for reduce in (np.fmin.reduce, np.fmax.reduce))
        if bottom == top < LOWEST_M and _is_typical(in_file(float(bottom))):
            remove(float(bottom), heights == bottom)
        step_m = max(_STEP_M, cell_m)
        for value in _cut_off(heights, step_m):
            cells = heights == value
            if _stands_alone(heights, cells, step_m) and _is_mark(in_file(value), cells):
                remove(value, cells)
        _require_joined(file, heights, step_m)
    warnings: list[str] = []
    if by_gap:
        for value in _far_from_all(heights, in_file, warnings):
            remove(value, heights == value)
    return heights, tuple(marks), tuple(warnings)


def marked(reading: Reading, marks: Iterable[Mark]) -> Reading:
    """Return a reading with the marks that were treated as voids."""
    marks = tuple(marks)
    if not marks:
        return reading
    known = reading.facts.get("marks", ())
    facts = {**reading.facts, "marks": [*known, *(mark.to_dict() for mark in marks)]}
    notes = (
        Remark(
            Grade.WARNING,
            f"{_cells(mark.cells)} {number(mark.value)}, which is no height here; the file does "
            "not declare it as a mark, and it is taken for a void.",
        )
        for mark in marks
    )
    return Reading(facts, reading.remarks).adding(notes)


def _cells(count: int) -> str:
    return f"{count:,} cells hold" if count != 1 else "1 cell holds"


def _outside(heights: Floats) -> Bools:
    return (heights < DEEPEST_M) | (heights > HIGHEST_M)


def _beyond_all_ground(file: _File, heights: Floats) -> Iterator[tuple[float, Bools]]:
    """Yield marks that cannot be the height of ground, and their cells."""
    outside = _outside(heights)
    inside = heights[~outside]
    low, high = np.fmin.reduce(inside, initial=np.inf), np.fmax.reduce(inside, initial=-np.inf)
    values = np.unique(heights[outside])
    cause = f"lie outside {DEEPEST_M:,g} to {HIGHEST_M:,g} m"
    if len(values) > _MOST_MARKS:
        raise file.refusal(heights, outside, cause)
    for value in values.tolist():
        cells = heights == value
        is_far = value < low - _GAP_M or value > high + _GAP_M
        if not (is_far and _is_mark(file.in_file(value), cells)):
            raise file.refusal(heights, outside, cause)
        yield value, cells


def _neighbours(heights: NDArray[_Kind]) -> Iterator[tuple[NDArray[_Kind], NDArray[_Kind]]]:
    """Yield pairs of views of neighbours, in columns and in rows."""
    yield heights[:-1], heights[1:]
    yield heights[:, :-1], heights[:, 1:]


def _cut_off(heights: Floats, step_m: float) -> list[float]:
    """Return the most common values below -500 m at the foot of a step that ground cannot have."""
    feet = []
    with np.errstate(invalid="ignore"):
        for first, second in _neighbours(heights):
            feet += [first[second - first > step_m], second[first - second > step_m]]
    values = np.concatenate(feet)
    found, counts = np.unique(values[values < LOWEST_M], return_counts=True)
    commonest: list[float] = found[np.argsort(-counts, kind="stable")[:_MOST_MARKS]].tolist()
    return commonest


def _stands_alone(heights: Floats, cells: Bools, step_m: float) -> bool:
    """Return whether nearly all neighbours of a value's cells are a large step away."""
    steps = large = 0
    for (first, second), (is_first, is_second) in zip(
        _neighbours(heights), _neighbours(cells), strict=True
    ):
        border = (is_first != is_second) & ~np.isnan(first) & ~np.isnan(second)
        steps += int(border.sum())
        large += int((np.abs(first[border] - second[border]) > step_m).sum())
    return steps > 0 and large >= _MOST_STEPS * steps


def _require_joined(file: _File, heights: Floats, step_m: float) -> None:
    """Check that heights below -500 m join the higher ground that they touch.

    Raises
    ------
    InputError
        If an area of them ends everywhere in steps that ground cannot have.
    """
    deep = heights < LOWEST_M
    if not deep.any():
        return
    # Loads SciPy, which terrains above the sea do not need.
    from scipy.ndimage import label

    areas, count = label(deep, np.ones((3, 3)))
    shores = np.zeros((2, count + 1), dtype=np.int64)
    for (first, second), (area, other) in zip(
        _neighbours(heights), _neighbours(areas), strict=True
    ):
        shore = ((area == 0) != (other == 0)) & ~np.isnan(first) & ~np.isnan(second)
        joined = np.abs(first[shore] - second[shore]) <= step_m
        of_area = np.maximum(area[shore], other[shore])
        shores[0] += np.bincount(of_area, minlength=count + 1)
        shores[1] += np.bincount(of_area[joined], minlength=count + 1)
    apart = (shores[0] > 0) & (shores[1] == 0)
    apart[0] = False
    if apart.any():
        raise file.refusal(
            heights, apart[areas], f"lie below {LOWEST_M:g} m and do not join the ground around"
        )


def _far_from_all(
    heights: Floats, in_file: Callable[[float], float], warnings: list[str]
) -> list[float]:
    """Return marks among values that ground can have; warn of outliers."""
    low, high = np.fmin.reduce(heights, axis=None), np.fmax.reduce(heights, axis=None)
    if not high - low > _GAP_M:
        return []
    # A gap of all heights is also a gap of some of them, which take a hundredth of the time.
    every = max(1, int(math.sqrt(heights.size / _SAMPLE_CELLS)))
    sampled = _classes(heights[::every, ::every], low, high)
    sampled[[0, -1]] = 1
    if np.diff(np.flatnonzero(sampled)).max() <= _GAP_M / _CLASS_M:
        return []
    classes = _classes(heights, low, high)
    held = np.flatnonzero(classes)
    ends = np.flatnonzero(np.diff(held) > _GAP_M / _CLASS_M)
    if not ends.size:
        return []
    groups = []
    for first, last in zip(
        held[np.r_[0, ends + 1]].tolist(), held[np.r_[ends, len(held) - 1]].tolist(), strict=True
    ):
        # Half a class is enough for rounding: the next class with values is ten away.
        bottom, top = low + (first - 0.5) * _CLASS_M, low + (last + 1.5) * _CLASS_M
        inside = heights[(heights >= bottom) & (heights < top)]
        groups.append((float(inside.min()), float(inside.max()), len(inside)))
    ground = [group for group in groups if group[0] < group[1]]
    if not ground:
        return []
    largest = max(ground, key=lambda group: group[2])
    marks = []
    for index, (bottom, top, cells) in enumerate(groups):
        if (bottom, top, cells) == largest:
            continue
        apart = min(
            abs(first - second)
            for other in groups[max(index - 1, 0) : index + 2]
            if other != (bottom, top, cells)
            for first, second in ((bottom, other[1]), (top, other[0]))
        )
        if not apart > _GAP_M:
            continue
        is_repeated = cells > _FEW_CELLS or _is_typical(in_file(bottom))
        if bottom == top and is_repeated:
            marks.append(bottom)
            continue
        span = number(bottom) if bottom == top else f"{number(bottom)} to {number(top)}"
        warnings.append(
            f"{cells:,} heights of {span} m lie more than {_GAP_M:,g} m from all other heights; "
            "they are taken as ground."
        )
    return marks


def _classes(heights: Floats, low: float, high: float) -> NDArray[np.int64]:
    """Return the number of heights in each class from ``low`` to ``high``."""
    classes = np.zeros(int((high - low) / _CLASS_M) + 1, dtype=np.int64)
    rows = max(1, _BLOCK_CELLS // heights.shape[1])
    for start in range(0, len(heights), rows):
        block = heights[start : start + rows]
        numbers = ((block[~np.isnan(block)] - low) / _CLASS_M).astype(np.int64)
        classes += np.bincount(numbers, minlength=len(classes))
    return classes


def _is_mark(value: float, cells: Bools) -> bool:
    """Return whether a number that is not a height is a mark: repeated, or of a typical form."""
    return _is_typical(value) or int(cells.sum()) > 1


def _is_typical(value: float) -> bool:
    """Return whether a number has the form of a mark: nines, an end of a type, or far too great."""
    value = abs(_short(value))
    if value >= _NO_HEIGHT:
        return True
    if not value.is_integer():
        return bool(re.fullmatch(r"9{2,}\.9+", f"{value:.{_DIGITS}g}"))
    whole = int(value)
    powers = any((end & (end - 1)) == 0 for end in (whole, whole + 1))
    return re.fullmatch(r"9{3,}", str(whole)) is not None or (whole > 120 and powers)


def _short(value: float) -> float:
    """Return a number without the digits that scaling and single precision add."""
    if not math.isfinite(value):
        return value
    rounded = float(f"{value:.{_DIGITS + 3}g}")
    return rounded if abs(rounded - value) <= 1e-7 * abs(value) else value
