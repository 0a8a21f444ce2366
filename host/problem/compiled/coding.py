"""Coded cells of a map, compiled: see CODED_MAP in docs/protocol.md."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.protocol.messages import ESCAPE_ONES
from pathgene.host.problem.compiled.jit import compiled


__all__ = ["code", "count_bits", "rows_that_fit"]

Ints = NDArray[np.int32]
Bytes = NDArray[np.uint8]


@compiled
def _error(cells: Ints, row: int, column: int, top: int) -> int:
    """Return the coded error of the prediction of a cell; ``top`` is the highest altitude."""
    if column:
        rise = cells[row, column] - cells[row, column - 1]
        if row:
            rise -= cells[row - 1, column] - cells[row - 1, column - 1]
    else:
        rise = cells[row, 0] - (cells[row - 1, 0] if row else 0)
    half = (top + 1) >> 1
    signed: int = ((rise + half) & top) - half
    return 2 * signed if signed >= 0 else -2 * signed - 1


@compiled
def _row_bits(cells: Ints, row: int, altitude_bits: int, remainder_bits: int) -> int:
    """Return the bits of a row after the rows to the south."""
    total = 0
    for column in range(cells.shape[1]):
        ones = _error(cells, row, column, (1 << altitude_bits) - 1) >> remainder_bits
        if ones < ESCAPE_ONES:
            total += ones + 1 + remainder_bits
        else:
            total += ESCAPE_ONES + altitude_bits
    return total


@compiled
def rows_that_fit(
    cells: Ints, altitude_bits: int, remainder_bits: int, most: int
) -> tuple[int, int]:
    """Return how many rows take up to ``most`` bits, and their bits."""
    total = 0
    for row in range(len(cells)):
        bits = _row_bits(cells, row, altitude_bits, remainder_bits)
        if total + bits > most:
            return row, total
        total += bits
    return len(cells), total


@compiled
def count_bits(cells: Ints, altitude_bits: int, remainder_bits: int) -> int:
    """Return the bits of a rectangle, (rows, columns) int32."""
    return rows_that_fit(cells, altitude_bits, remainder_bits, 1 << 60)[1]


@compiled
def code(cells: Ints, altitude_bits: int, remainder_bits: int, coded: Bytes) -> int:
    """Write the code of a rectangle; return its number of bytes.

    Parameters
    ----------
    cells : (rows, columns) int32
        Altitudes.
    coded : (n,) uint8
        Zeros, enough for the bits of all rows.
    """
    top = (1 << altitude_bits) - 1
    at = 0
    for row in range(len(cells)):
        for column in range(cells.shape[1]):
            error = _error(cells, row, column, top)
            ones, count = error >> remainder_bits, remainder_bits
            value = error - (ones << remainder_bits)
            if ones >= ESCAPE_ONES:
                ones, count, value = ESCAPE_ONES, altitude_bits, cells[row, column]
            for _ in range(ones):
                coded[at >> 3] |= 1 << (at & 7)
                at += 1
            if ones < ESCAPE_ONES:
                at += 1
            for bit in range(count):
                coded[at >> 3] |= (value >> bit & 1) << (at & 7)
                at += 1
    return (at + 7) >> 3
