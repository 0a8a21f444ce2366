"""Model of the commands of the collision checker."""

from __future__ import annotations

from collections.abc import Sequence

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import CheckFlag, Counter, Status
from pathgene.hdl.protocol.messages import (
    CODED_COLUMNS,
    check_paths_request,
    check_reply,
    check_request,
    coded_map_request,
    map_request,
    results_request,
)
from pathgene.hdl.protocol.paths import PathResult, pack_results, unpack_cells
from pathgene.sim.model.checker import Point, TerrainModel, Verdict
from pathgene.sim.model.checker_cycles import batch_cycles
from pathgene.sim.model.checker_kernels import check_paths
from pathgene.sim.model.coded_cells import decode_cells
from pathgene.sim.model.requests import expect


__all__ = ["CheckingModel"]


class CheckingModel:
    """Executes MAP, CODED_MAP, CHECK, CHECK_PATHS and RESULTS.

    Attributes
    ----------
    counters : dict of Counter to int
        Sums over all checks.
    """

    def __init__(self, config: Config) -> None:
        self.config = config
        self.terrain = TerrainModel(config)
        counted = (Counter.FEASIBILITY, Counter.CELLS, Counter.READS, Counter.PATHS)
        self.counters = dict.fromkeys(counted, 0)
        self._results: list[PathResult] = []
        self._totals = dict.fromkeys((name for name, _ in check_reply(config).fields), 0)

    @property
    def checked(self) -> int:
        """Paths of the latest check."""
        return len(self._results)

    def write(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a MAP.

        A MAP of wrong length is refused, but the cells that it contains for its rectangle are
        written.
        """
        layout = map_request(self.config)
        expect(len(payload) >= layout.size, Status.BAD_LENGTH)
        x, y, width, height = layout.unpack(payload[: layout.size]).values()
        self._expect_on_map(x, y, width, height)
        packed = payload[layout.size :]
        cells = unpack_cells(self.config, packed)[: width * height]
        if not repeated:
            self._write(x, y, width, cells)
        size = (width * height * self.config.altitude_bits + 7) // 8
        expect(len(packed) == size, Status.BAD_LENGTH)
        return b""

    def write_coded(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a CODED_MAP; whole cells of one of wrong length are written, too."""
        layout = coded_map_request(self.config)
        expect(len(payload) >= layout.size, Status.BAD_LENGTH)
        fields = layout.unpack(payload[: layout.size]).values()
        x, y, width, height, remainder_bits = fields
        self._expect_on_map(x, y, width, height)
        expect(width <= CODED_COLUMNS, Status.BAD_VALUE)
        expect(remainder_bits < self.config.altitude_bits, Status.BAD_VALUE)
        coded = payload[layout.size :]
        cells, size = decode_cells(self.config, coded, width, height, remainder_bits)
        if not repeated:
            self._write(x, y, width, cells)
        expect(len(cells) == width * height and len(coded) == size, Status.BAD_LENGTH)
        return b""

    def _expect_on_map(self, x: int, y: int, width: int, height: int) -> None:
        expect(width > 0 and height > 0, Status.BAD_VALUE)
        edge = self.config.map_size
        expect(x + width <= edge and y + height <= edge, Status.BAD_VALUE)

    def _write(self, x: int, y: int, width: int, cells: list[int]) -> None:
        """Write cells by rows, perhaps fewer than a rectangle's."""
        rows, rest = divmod(len(cells), width)
        if rows:
            block = [cells[width * row : width * (row + 1)] for row in range(rows)]
            self.terrain.write(x, y, block)
        if rest:
            self.terrain.write(x, y + rows, [cells[-rest:]])

    def check(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a CHECK."""
        header = check_request(self.config).size
        expect(len(payload) >= header, Status.BAD_LENGTH)
        flags = _flags(payload[0])
        packed, size = payload[header:], self.config.waypoint_bytes
        expect(len(packed) > 0 and len(packed) % size == 0, Status.BAD_LENGTH)
        words = [
            int.from_bytes(packed[at : at + size], "little") for at in range(0, len(packed), size)
        ]
        lasts = [word >> self.config.waypoint_bits & 1 for word in words]
        expect(2 <= len(words) <= self.config.max_waypoints + 2, Status.BAD_VALUE)
        expect(lasts[-1] == sum(lasts) == 1, Status.BAD_VALUE)
        if not repeated:
            self._run([words], flags)
        return self._answer(flags)

    def check_paths(
        self, population: Sequence[Sequence[int]], payload: bytes, repeated: bool
    ) -> bytes:
        """Execute a CHECK_PATHS on ``population``, the packed paths of all slots."""
        layout = check_paths_request(self.config)
        expect(len(payload) == layout.size, Status.BAD_LENGTH)
        slot, count, number, start, goal = layout.unpack(payload).values()
        flags = _flags(number)
        expect(count >= 1 and slot + count <= self.config.population, Status.BAD_VALUE)
        if not repeated:
            paths = population[slot : slot + count]
            self._run([[start, *path, goal] for path in paths], flags)
        return self._answer(flags)

    def results(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a RESULTS."""
        layout = results_request(self.config)
        expect(len(payload) == layout.size, Status.BAD_LENGTH)
        path, count = payload
        expect(count >= 1 and path + count <= self.checked, Status.BAD_VALUE)
        return pack_results(self.config, self._results[path : path + count])

    def _run(self, paths: Sequence[Sequence[int]], flags: CheckFlag) -> None:
        counting = bool(flags & CheckFlag.COUNT)
        queue = [[self._point(word) for word in path] for path in paths]
        verdicts = check_paths(self.config, self.terrain, queue, counting)
        spent = batch_cycles(self.config, self.terrain, queue, counting)
        self._results = [_result(verdict) for verdict in verdicts]
        self._totals = {
            "cycles": sum(cycles for cycles, _ in spent),
            "reads": sum(reads for _, reads in spent),
            "cells": sum(verdict.cells for verdict in verdicts),
        }
        self.counters[Counter.FEASIBILITY] += self._totals["cycles"]
        self.counters[Counter.READS] += self._totals["reads"]
        self.counters[Counter.CELLS] += self._totals["cells"]
        self.counters[Counter.PATHS] += len(paths)

    def _point(self, word: int) -> Point:
        bits = self.config.coordinate_bits
        mask = (1 << bits) - 1
        altitude = word >> 2 * bits & self.config.blocked_altitude
        return word & mask, word >> bits & mask, altitude

    def _answer(self, flags: CheckFlag) -> bytes:
        totals = check_reply(self.config).pack(**self._totals)
        if flags & CheckFlag.BRIEF:
            return totals
        return totals + pack_results(self.config, self._results)


def _flags(value: int) -> CheckFlag:
    expect(value < 1 << len(CheckFlag), Status.BAD_VALUE)
    return CheckFlag(value)


def _result(verdict: Verdict) -> PathResult:
    if not verdict.collision:
        return PathResult()
    return PathResult(
        collision=True,
        segment=verdict.segment,
        cell=(verdict.x, verdict.y),
        coarse=verdict.coarse,
        cells=verdict.cells,
        entries=verdict.entries,
    )
