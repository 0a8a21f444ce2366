"""Numbers that are not heights: marks of voids that a file does not declare."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.remarks import Grade, Reading, Remark
from pathgene.host.terrain.file_heights import FileHeights, neighbours
from pathgene.host.terrain.gaps import GAP_M, far_groups, joins
from pathgene.host.terrain.stated import EVERY_HEIGHT, Stated
from pathgene.host.terrain.voids import HIGHEST_M, LOWEST_FLOOR_M, LOWEST_M, holds, number


__all__ = ["Mark", "marked", "named", "without_marks"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

#: A larger step between neighbours is not ground, metres; in larger cells it is a cell's side.
_STEP_M = 300.0
#: Share of the steps around a value that must be that large.
_MOST_STEPS = 0.75
#: A value in this number of cells or fewer may be an outlier.
_FEW_CELLS = 3
#: Maximum number of different marks in a file.
_MOST_MARKS = 8
# Numbers from here on are not a height in any unit.
_NO_HEIGHT = 1e5
# The numbers that --void none accepts.
_RANGE = f"All numbers from {LOWEST_FLOOR_M:,g} to {HIGHEST_M:,g} m"
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


def without_marks(
    file: FileHeights,
    heights: Floats,
    *,
    by_gap: bool = True,
    accepts_all: bool = False,
) -> tuple[Floats, tuple[Mark, ...]]:
    """Return heights with NaN for all marks of voids, and the marks.

    A mark is one number, repeated or of a typical form, that lies outside -11,000 to 9,000 m, or
    below -500 m without joining the heights around it, or more than 1,000 m from all other values
    without ground between. Call it before heights are interpolated, which mixes marks with the
    ground.

    Parameters
    ----------
    file : FileHeights
        Name, places and numbers for messages.
    heights : ndarray
        ``(rows, columns)`` float64 metres; NaN is a void.
    by_gap : bool
        Also look for values that are possible heights, far from all other values.
    accepts_all : bool
        Take all numbers from -11,000 to 9,000 m as heights.

    Raises
    ------
    InputError
        If such numbers are not marks.
    """
    # No array in the usual case; `fmin` and `fmax` ignore voids.
    low, high = np.fmin.reduce(heights, axis=None), np.fmax.reduce(heights, axis=None)
    if low >= LOWEST_M and high <= HIGHEST_M and not (by_gap and high - low > GAP_M):
        return heights, ()
    marks: list[Mark] = []

    def remove(value: float, cells: Bools) -> None:
        nonlocal heights
        if not marks:
            heights = heights.copy()
        marks.append(Mark(_short(file.in_file(value)), int(cells.sum())))
        heights[cells] = np.nan

    if low < LOWEST_FLOOR_M or high > HIGHEST_M:
        for value, cells in list(_beyond_all_ground(file, heights)):
            remove(value, cells)
    if accepts_all:
        return heights, tuple(marks)
    if low < LOWEST_M:
        bottom, top = (reduce(heights, axis=None) for reduce in (np.fmin.reduce, np.fmax.reduce))
        if bottom == top < LOWEST_M and _is_typical(file.in_file(float(bottom))):
            remove(float(bottom), heights == bottom)
        step_m = max(_STEP_M, file.cell_m)
        for value in _cut_off(heights, step_m):
            cells = heights == value
            if _stands_alone(heights, cells, step_m) and _is_mark(file.in_file(value), cells):
                remove(value, cells)
        _require_joined(file, heights, step_m, marks[0].value if marks else None)
    if by_gap:
        for value, cells in list(_far_from_all(file, heights)):
            remove(value, cells)
    return heights, tuple(marks)


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


def named(reading: Reading, numbers: NDArray[Any], stated: Stated) -> tuple[Reading, Bools | None]:
    """Return a reading with the marks that the user names, and the cells that hold them.

    Parameters
    ----------
    numbers : ndarray
        The numbers of the file.
    """
    if stated.void is None:
        return reading, None
    if stated.accepts_all:
        facts = {**reading.facts, "named_void": EVERY_HEIGHT}
        note = Remark(Grade.NOTE, f"{_RANGE} are taken as heights, as --void none states.")
        return Reading(facts, (*reading.remarks, note)), None
    cells, marks, remarks = np.zeros(numbers.shape, dtype=bool), [], []
    for value in stated.marks:
        held = holds(numbers, value)
        cells |= held
        mark = Mark(value, int(held.sum()))
        marks.append(mark.to_dict())
        text = number(value)
        remarks.append(
            Remark(Grade.NOTE, f"{_cells(mark.cells)} {text}, a void as --void states.")
            if mark.cells
            else Remark(Grade.WARNING, f"No cell holds {text}, which --void names as a void.")
        )
    return Reading({**reading.facts, "named_void": marks}, reading.remarks).adding(remarks), cells


def _cells(count: int) -> str:
    return f"{count:,} cells hold" if count != 1 else "1 cell holds"


def _outside(heights: Floats) -> Bools:
    return (heights < LOWEST_FLOOR_M) | (heights > HIGHEST_M)


def _beyond_all_ground(file: FileHeights, heights: Floats) -> Iterator[tuple[float, Bools]]:
    """Yield marks that cannot be the height of ground, and their cells."""
    outside = _outside(heights)
    inside = heights[~outside]
    low, high = np.fmin.reduce(inside, initial=np.inf), np.fmax.reduce(inside, initial=-np.inf)
    values = np.unique(heights[outside])
    where = f"outside {LOWEST_FLOOR_M:,g} to {HIGHEST_M:,g} m"
    if len(values) > _MOST_MARKS:
        raise file.refusal(heights, outside, where)
    for value in values.tolist():
        cells = heights == value
        is_far = value < low - GAP_M or value > high + GAP_M
        if not (is_far and _is_mark(file.in_file(value), cells)):
            raise file.refusal(heights, outside, where)
        yield value, cells


def _cut_off(heights: Floats, step_m: float) -> list[float]:
    """Return the most common values below -500 m at the foot of a step that ground cannot have."""
    feet = []
    with np.errstate(invalid="ignore"):
        for first, second in neighbours(heights):
            feet += [first[second - first > step_m], second[first - second > step_m]]
    values = np.concatenate(feet)
    found, counts = np.unique(values[values < LOWEST_M], return_counts=True)
    commonest: list[float] = found[np.argsort(-counts, kind="stable")[:_MOST_MARKS]].tolist()
    return commonest


def _stands_alone(heights: Floats, cells: Bools, step_m: float) -> bool:
    """Return whether nearly all neighbours of a value's cells are a large step away."""
    steps = large = 0
    for (first, second), (is_first, is_second) in zip(
        neighbours(heights), neighbours(cells), strict=True
    ):
        border = (is_first != is_second) & ~np.isnan(first) & ~np.isnan(second)
        steps += int(border.sum())
        large += int((np.abs(first[border] - second[border]) > step_m).sum())
    return steps > 0 and large >= _MOST_STEPS * steps


def _require_joined(file: FileHeights, heights: Floats, step_m: float, mark: float | None) -> None:
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
    for (first, second), (area, other) in zip(neighbours(heights), neighbours(areas), strict=True):
        shore = ((area == 0) != (other == 0)) & ~np.isnan(first) & ~np.isnan(second)
        joined = np.abs(first[shore] - second[shore]) <= step_m
        of_area = np.maximum(area[shore], other[shore])
        shores[0] += np.bincount(of_area, minlength=count + 1)
        shores[1] += np.bincount(of_area[joined], minlength=count + 1)
    apart = (shores[0] > 0) & (shores[1] == 0)
    apart[0] = False
    if apart.any():
        raise file.refusal(
            heights,
            apart[areas],
            f"below {LOWEST_M:g} m, with no slope to the ground around",
            mark,
        )


def _far_from_all(file: FileHeights, heights: Floats) -> Iterator[tuple[float, Bools]]:
    """Yield marks among values that ground can have, and their cells.

    Raises
    ------
    InputError
        If values far from all other values are neither marks nor joined to the ground around them.
    """
    for group in far_groups(heights):
        cells = group.mask(heights)
        is_joined = joins(heights, cells, file.cell_m)
        is_typical = group.is_one_value and _is_typical(file.in_file(group.bottom))
        is_repeated = group.is_one_value and group.cells > _FEW_CELLS
        if (is_typical and is_repeated) or ((is_typical or is_repeated) and not is_joined):
            yield group.bottom, cells
        elif not is_joined:
            raise file.refusal(
                heights, cells, f"more than {GAP_M:,g} m from all other heights, with no ground "
                "between",
            )  # fmt: skip


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
