"""The Verilated collision checker as a program that runs at full speed, without a link."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import JobError
from pathgene.sim.exported import exported_verilog
from pathgene.sim.harness.program import VerilatedProgram


if TYPE_CHECKING:
    from pathgene.hdl.config import Config

__all__ = ["CheckerBatch", "VerilatedChecker"]

_MAIN = Path(__file__).with_name("checker_main.cpp")
_WRITE, _CHECK, _LOOK_UP = 1, 2, 3

Point = Sequence[int]
Fields = dict[str, int]


@dataclass(frozen=True)
class CheckerBatch:
    """Results of a batch of paths.

    Attributes
    ----------
    verdicts : list of dict
        Fields of ``verdict_layout`` of each path.
    entries : list of list of dict
        Fields of ``count_layout`` of each path.
    offered : list of int
        Cycle in which each verdict was first offered; the first point has cycle 1.
    cycles : int
        Cycles from the first point to the transfer of the last verdict.
    """

    verdicts: list[Fields]
    entries: list[list[Fields]]
    offered: list[int]
    cycles: int


class VerilatedChecker(VerilatedProgram):
    """The checker of one configuration, simulated by Verilator in another process.

    Parameters
    ----------
    config : Config
        Sizes of a build with a checker.

    Raises
    ------
    JobError
        As from :class:`pathgene.sim.harness.program.VerilatedProgram`.
    """

    def __init__(self, config: Config) -> None:
        from pathgene.hdl.feasibility.layouts import count_layout, verdict_layout
        from pathgene.hdl.layouts import cell_layout, point_layout

        self.config = config
        self._cell = cell_layout(config.coordinate_bits, config.altitude_bits)
        self._point = point_layout(config.coordinate_bits, config.altitude_bits)
        self._verdict = verdict_layout(
            config.coordinate_bits, config.segment_bits, config.path_cells_bits
        )
        self._count = count_layout(config.coordinate_bits, config.segment_bits)
        super().__init__(exported_verilog("path_checker", config), "path_checker", _MAIN)

    def write(self, heights: NDArray[np.integer], x: int = 0, y: int = 0) -> None:
        """Write a rectangle of the map at ``x, y``: ``heights`` [y, x], in altitude steps."""
        rows, columns = heights.shape
        bits = self.config.coordinate_bits
        ys, xs = np.mgrid[y : y + rows, x : x + columns].astype(np.uint64)
        words = xs | ys << np.uint64(bits) | heights.astype(np.uint64) << np.uint64(2 * bits)
        words.flat[-1] |= np.uint64(1 << 2 * bits + self.config.altitude_bits)
        self.send(_WRITE, words.size, words.ravel())

    def check(
        self, paths: Iterable[Sequence[Point]], *, count: bool = False, stall: int = 0
    ) -> CheckerBatch:
        """Check ``paths`` back to back, each 2 or more points ``x, y, altitude``.

        With ``stall`` above 0, answers are only taken in one of every ``stall`` cycles.
        """
        batch = [self._packed(path) for path in paths]
        words = np.concatenate(batch)
        self.send(_CHECK, int(count), stall, words.size, words, len(batch))
        width = _numbers(self._verdict.size)
        raw = self.receive(len(batch) * (width + 1)).reshape(len(batch), width + 1)
        verdicts = [_unpack(self._verdict, row[:width]) for row in raw]
        total = int(self.receive(1)[0])
        width = _numbers(self._count.size)
        counts = self.receive(total * width).reshape(total, width)
        rows = iter([_unpack(self._count, row) for row in counts])
        entries = [[next(rows) for _ in range(verdict["entries"])] for verdict in verdicts]
        if next(rows, None) is not None:
            raise JobError("The checker offered more counts than its verdicts announce.")
        return CheckerBatch(verdicts, entries, raw[:, -1].tolist(), int(self.receive(1)[0]))

    def look_up(self, cells: Sequence[tuple[int, int]], latency: int) -> list[int]:
        """Return the altitude at each of ``cells`` (x, y), read one per cycle."""
        words = np.array([x | y << 32 for x, y in cells], dtype=np.uint64)
        self.send(_LOOK_UP, latency, words.size, words)
        altitudes: list[int] = self.receive(len(cells)).tolist()
        return altitudes

    def _packed(self, path: Sequence[Point]) -> NDArray[np.uint64]:
        bits = self.config.coordinate_bits
        points = np.asarray(path, dtype=np.uint64)
        words: NDArray[np.uint64] = (
            points[:, 0] | points[:, 1] << np.uint64(bits) | points[:, 2] << np.uint64(2 * bits)
        )
        words[-1] |= np.uint64(1 << 2 * bits + self.config.altitude_bits)
        return words


def _numbers(bits: int) -> int:
    # As large as the C++ type of the port: 8, 16, 32 or 64 bits, or 32-bit words.
    return max(1, -(-bits // 64))


def _unpack(layout: Any, row: NDArray[np.uint64]) -> Fields:
    packed = sum(int(number) << 64 * i for i, number in enumerate(row))
    constant = layout.from_bits(packed & ((1 << layout.size) - 1))
    return {name: int(constant[name]) for name, _ in layout}
