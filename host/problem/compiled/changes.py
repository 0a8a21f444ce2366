"""Changes of a chip's map, by the tiles that one frame each can write."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pathgene.host.problem.compiled.jit import compiled


__all__ = ["find_changes"]


@compiled
def find_changes(
    before: NDArray[np.int32],
    after: NDArray[np.uint16] | NDArray[np.int32],
    tile: tuple[int, int],
    boxes: NDArray[np.int32],
) -> None:
    """Write the box around the changes of each tile.

    Parameters
    ----------
    before, after : (rows, columns) integers
        The map, in tiles from its first row and column on.
    tile : (int, int)
        Rows and columns of a tile.
    boxes : (tiles up, tiles across, 4) int32
        First row, row after the last, and the same of the columns. On entry, the first are great
        and the last 0; tiles without a change are not written.
    """
    high, wide = tile
    columns = before.shape[1]
    for row in range(before.shape[0]):
        # The compiler turns a loop without a branch into vector instructions.
        differs = np.int32(0)
        for column in range(columns):
            differs |= before[row, column] ^ np.int32(after[row, column])
        if differs == 0:
            continue
        for column in range(columns):
            if before[row, column] != after[row, column]:
                box = boxes[row // high, column // wide]
                box[0] = min(box[0], row)
                box[1] = max(box[1], row + 1)
                box[2] = min(box[2], column)
                box[3] = max(box[3], column + 1)
