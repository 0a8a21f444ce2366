"""Memo of segments: hits and margins of segments walked before, by their ends."""

from __future__ import annotations

from pathgene.hdl.config import Config
from pathgene.sim.model.planner.definition.walk import Point


__all__ = ["Memo"]


class Memo:
    """Direct-mapped table with whole tags: it never answers for another segment.

    Parameters
    ----------
    config : Config
    size : int
        Segments: 0, or a power of two.
    """

    def __init__(self, config: Config, size: int) -> None:
        self._config, self._size = config, size
        self._rows: dict[int, tuple[tuple[Point, Point], tuple[int, int]]] = {}

    def get(self, start: Point, stop: Point) -> tuple[int, int] | None:
        """Return hits and margin of a segment; None if they are not in the table."""
        row = self._rows.get(self._index(start, stop))
        return row[1] if row is not None and row[0] == (start, stop) else None

    def put(self, start: Point, stop: Point, walked: tuple[int, int]) -> None:
        """Keep hits and margin of a segment in the place of another one's."""
        if self._size:
            self._rows[self._index(start, stop)] = (start, stop), walked

    def _index(self, start: Point, stop: Point) -> int:
        """Return the segment's row: its ends, one shifted, folded by exclusive or."""
        if not self._size:
            return 0
        mixed = self._packed(start) ^ self._packed(stop) << 3
        index = 0
        while mixed:
            index ^= mixed & self._size - 1
            mixed >>= self._size.bit_length() - 1
        return index

    def _packed(self, point: Point) -> int:
        x, y, z = point
        return x | y << self._config.coordinate_bits | z << 2 * self._config.coordinate_bits
