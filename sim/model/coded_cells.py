"""Decoder of the cells of a CODED_MAP, compiled."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.messages import ESCAPE_ONES
from pathgene.sim.model.compiled import compiled


__all__ = ["decode_cells"]

Integers = npt.NDArray[np.integer]


def decode_cells(
    config: Config, payload: bytes, width: int, height: int, remainder_bits: int
) -> tuple[list[int], int]:
    """Return the whole cells in ``payload``, by rows, and the bytes that they take.

    There are at most ``height`` rows of ``width`` cells: see
    :func:`pathgene.hdl.protocol.messages.coded_map_request`.
    """
    data = np.frombuffer(payload, dtype=np.uint8)
    cells = np.zeros(width * height, dtype=np.int64)
    count, bits = _decode(data, width, config.altitude_bits, remainder_bits, cells)
    return cells[:count].tolist(), -(-bits // 8)


@compiled
def _decode(
    data: Integers, width: int, altitude_bits: int, remainder_bits: int, cells: Integers
) -> tuple[int, int]:
    """Write the whole cells; return their number and their bits."""
    mask = (1 << altitude_bits) - 1
    end = 8 * len(data)
    at = used = 0
    for number in range(len(cells)):
        column = number % width
        ones = 0
        while at < end and ones < ESCAPE_ONES and data[at >> 3] >> (at & 7) & 1:
            ones += 1
            at += 1
        following = altitude_bits
        if ones < ESCAPE_ONES:
            at += 1
            following = remainder_bits
        if at + following > end:
            return number, used
        value = 0
        for bit in range(following):
            value |= (data[at >> 3] >> (at & 7) & 1) << bit
            at += 1
        # The cell to the west, or in the first column the cell to the south.
        west = number - 1 if column else number - width
        before = cells[west] if number else 0
        if ones == ESCAPE_ONES:
            cells[number] = value
        else:
            coded = (ones << remainder_bits) + value
            rise = -(coded + 1 >> 1) if coded & 1 else coded >> 1
            if column and number >= width:
                rise += cells[number - width] - cells[number - width - 1]
            cells[number] = before + rise & mask
        used = at
    return len(cells), used
