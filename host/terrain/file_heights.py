"""The heights of a file as sentences describe them: places, numbers in the file, and remedies."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.terrain.stated import EVERY_HEIGHT, HEIGHT_UNITS
from pathgene.host.terrain.voids import HIGHEST_M, LOWEST_FLOOR_M, LOWEST_M, number


__all__ = ["FileHeights", "neighbours", "remedy_of_array", "remedy_of_file"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
# Different whole numbers that are no marks, since a file has one or two.
_MANY_NUMBERS = 4
_Kind = TypeVar("_Kind", bound=np.generic)


@dataclass(frozen=True)
class FileHeights:
    """Description of the heights of a file, for messages about them.

    Parameters
    ----------
    name : str
        Name of the terrain.
    cell_m : float
        Longer side of a cell, metres.
    place : callable
        Takes row and column of a node and returns its place, in words.
    remedy : callable
        Takes the number of a node in the file, and whether ground may have this height, and returns
        advice for the user, in words.
    in_file : callable
        Takes a height in metres and returns the number in the file.
    zero_m : float
        The height of the number 0 in the file, metres.
    """

    name: str
    cell_m: float
    place: Callable[[int, int], str]
    remedy: Callable[[float, bool], str]
    in_file: Callable[[float], float] = float
    zero_m: float = 0.0

    def place_of_first(self, cells: Bools) -> str:
        """Return the place of the first of some cells."""
        row, column = np.unravel_index(int(np.argmax(cells)), cells.shape)
        return self.place(int(row), int(column))

    def refusal(
        self, heights: Floats, bad: Bools, where: str, mark: float | None = None
    ) -> InputError:
        """Return the refusal of the ``bad`` heights, with the first of them.

        Parameters
        ----------
        where : str
            The range of the bad heights, after "lie".
        mark : float, optional
            A mark of voids in the file, which resampling may have mixed into the bad heights.
        """
        count, height = int(bad.sum()), float(heights[bad][0])
        verb = "lies" if count == 1 else "lie"
        first = f"the first, {self.place_of_first(bad)}, is {number(height)} m"
        values = np.unique(heights[bad])
        numbers, is_whole = len(values), (values == np.rint(values)).all()
        if numbers >= (_MANY_NUMBERS if is_whole else 2) and values[-1] < LOWEST_M:
            return InputError(
                f"{self.name}: {count:,} of {heights.size:,} heights {verb} {where}; {first}. They "
                f"are {numbers:,} different numbers: resampling has probably mixed a mark of voids "
                "into them; resample again from the original with gdalwarp -srcnodata "
                f"{'MARK' if mark is None else number(mark)}."
            )
        is_possible = LOWEST_FLOOR_M <= height <= HIGHEST_M
        remedy = self.remedy(self.in_file(height), is_possible)
        return InputError(
            f"{self.name}: {count:,} of {heights.size:,} heights {verb} {where}; {first}, probably "
            f"a void mark that is not declared, or no height in metres: {remedy}."
        )


def remedy_of_file(value: float, is_possible: bool) -> str:
    """Return advice on a number of a file that is no height."""
    unit = f"state the unit of the heights (--height-unit {'|'.join(HEIGHT_UNITS)})"
    mark = f"name the mark (--void {number(value)})"
    if not is_possible:
        return f"{mark}, or {unit}"
    return f"{mark}, {unit}, or accept all numbers as heights (--void {EVERY_HEIGHT})"


def remedy_of_array(value: float, is_possible: bool) -> str:
    """Return advice on a number of an array that is no height."""
    return "write NaN where there is no height"


def neighbours(heights: NDArray[_Kind]) -> Iterator[tuple[NDArray[_Kind], NDArray[_Kind]]]:
    """Yield pairs of views of neighbours, in columns and in rows."""
    yield heights[:-1], heights[1:]
    yield heights[:, :-1], heights[:, 1:]
