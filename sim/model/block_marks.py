"""Marks of the blocks of the map that have changed since they were scanned."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from pathgene.hdl.protocol.planner import BLOCKS


__all__ = ["BlockMarks"]

Corners = npt.NDArray[np.integer]


class BlockMarks:
    """Which blocks a run scans: the marks of ``BlockMap``.

    A corner that is written marks its block; corners beyond the blocks mark none. All blocks are
    scanned the first time, and where a corner was written, or a scan begins, with another size of
    blocks than the previous scan.

    Attributes
    ----------
    shift : int
        The size of blocks in force: ``2**shift`` corners along each edge.
    """

    def __init__(self) -> None:
        self.shift = 0
        self._marks = np.zeros((BLOCKS, BLOCKS), dtype=bool)
        self._scanned_shift: int | None = None

    def write(self, x: Corners, y: Corners) -> None:
        """Mark the blocks of corners.

        Parameters
        ----------
        x, y : ndarray
            Integers of shapes that broadcast: each pair is a corner.
        """
        if x.size == 0 or y.size == 0:
            return
        if self.shift != self._scanned_shift:
            self._scanned_shift = None
        x, y = np.broadcast_arrays(x >> self.shift, y >> self.shift)
        on_blocks = np.maximum(x, y) < BLOCKS
        self._marks[y[on_blocks], x[on_blocks]] = True

    def scan(self) -> int:
        """Return the number of blocks that a scan reads, and take the marks away."""
        is_known = self._scanned_shift == self.shift
        marked = int(self._marks.sum()) if is_known else self._marks.size
        self._marks[:] = False
        self._scanned_shift = self.shift
        return marked
