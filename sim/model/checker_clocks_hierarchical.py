"""Clocks and memory accesses of the hierarchical build, without simulating its clocks."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from hdl.config import Config
from hdl.feasibility.sizes import COLUMN_TASKS, SPAN_STAGES, VERDICT_PLACES, count_places
from sim.model.checker import Point, TerrainModel, check_path, segment_cells, walk


__all__ = ["Column", "hierarchical_clocks", "segment_columns"]

_NEVER = 1 << 62


@dataclass(frozen=True)
class Column:
    """Cells of a segment beside the same coarse blocks.

    Attributes
    ----------
    first : int
        Number of its first cell in the segment.
    groups : tuple of int
        Cells that are walked in each clock, if they must be.
    blocks : int
        Coarse blocks that are read, 1 or 2.
    walked : bool
        One of them is not below its lowest cell.
    ends_segment : bool
    """

    first: int
    groups: tuple[int, ...]
    blocks: int
    walked: bool
    ends_segment: bool


def segment_columns(
    config: Config, terrain: TerrainModel, start: Point, stop: Point
) -> Iterator[Column]:
    """Yield the columns of a segment in order."""
    factor = config.coarse_factor
    group = min(config.lanes, factor)
    cells = list(walk(start, stop))
    steep = abs(stop[1] - start[1]) > abs(stop[0] - start[0])
    majors = [y if steep else x for x, y, _ in cells]
    first = 0
    for _, members in itertools.groupby(majors, key=lambda major: major // factor):
        column = list(members)
        last = first + len(column) - 1
        blocks = {(cells[k][1] // factor, cells[k][0] // factor) for k in (first, last)}
        lowest = min(math.ceil(cells[k][2]) for k in (first, last))
        yield Column(
            first,
            tuple(
                len(list(few)) for _, few in itertools.groupby(column, lambda major: major // group)
            ),
            len(blocks),
            any(terrain.coarse[block] >= lowest for block in blocks),
            last == len(cells) - 1,
        )
        first = last + 1


def hierarchical_clocks(
    config: Config, terrain: TerrainModel, paths: Iterable[Sequence[Point]], count: bool = False
) -> list[tuple[int, int]]:
    """Return the cycles and the reads in the verdict of every path of a queue.

    The source always has the next point and verdicts are taken at once; the chip is idle before
    the first path. A queue of one path is a path by itself.

    Parameters
    ----------
    config : Config
        Of the hierarchical build.
    terrain : TerrainModel
    paths : iterable of sequences of (int, int, int)
    count : bool
        Count mode.
    """
    pipeline = _Pipeline(config, terrain, count)
    return [pipeline.check(path) for path in paths]


class _Pipeline:
    """When each stage is free for the next one, after the paths so far. Clocks count from 1."""

    def __init__(self, config: Config, terrain: TerrainModel, count: bool) -> None:
        self._config = config
        self._terrain = terrain
        self._count = count
        self._probe = config.memory_latency + 1  # Clocks from a column to its task,
        lead = 0 if config.lanes == 1 else 2
        self._answer = lead + config.memory_latency + 3  # and from a group to its step.
        self._places = count_places(config)
        self._taken = 0  # The latest point.
        self._left = [0] * SPAN_STAGES  # When the latest segment left each stage of the set-up.
        self._columns_free = 0  # From when on a segment can be taken,
        self._cells_free = 0  # and a task.
        self._returns: list[int] = []  # When the columns under way give back their places.
        self._freed: list[int] = []  # From when on the place of each counted segment is free.
        self._offered: list[int] = []  # Verdicts.

    def check(self, path: Sequence[Point]) -> tuple[int, int]:
        """Return cycles and reads of the next path."""
        config = self._config
        outcome = check_path(config, self._terrain, path, self._count)
        counted = {segment for segment, _, _ in outcome.entries}
        began = self._taken = self._taken + 1
        hit: int | None = None  # Step that ends the walk.
        dropped = False  # While there were segments left, or columns.
        waiting: list[int] = []  # When the tasks are there that are still left at the hit.
        reads = cells = 0
        for number, (start, stop) in enumerate(itertools.pairwise(path)):
            ready = self._set_up()
            clock = self._next(ready, number)
            if hit is not None and (dropped or clock >= hit):
                dropped = True
                self._left[-1] = max(ready, hit + 1, self._left[-1] + 1)
                continue
            self._left[-1] = clock
            for column in segment_columns(config, self._terrain, start, stop):
                clock = self._place(clock + 1, len(waiting))
                if hit is not None and clock >= hit:
                    dropped = True
                    reads += column.blocks if clock == hit else 0
                    break
                reads += column.blocks
                decided = clock + self._probe
                if not column.walked and not column.ends_segment:
                    self._returns.append(decided)
                    continue
                taken = max(decided + 1, self._cells_free)
                if hit is not None and taken >= hit:
                    waiting.append(decided + 1)
                    continue
                self._returns.append(taken)
                self._cells_free = taken + (len(column.groups) if column.walked else 1)
                if not column.walked:
                    continue
                passed = cells + column.first
                for group, size in enumerate(column.groups, start=taken + 1):
                    reads += size if hit is None or group <= hit else 0
                    passed += size
                    stops = outcome.collision and not self._count and hit is None
                    if stops and passed >= outcome.cells:
                        hit = group + self._answer
            self._columns_free = clock
            cells += segment_cells(start, stop)
            if self._count:
                self._freed.append(
                    self._cells_free + self._answer + (2 if number in counted else 1)
                )
        if hit is None:
            step = self._cells_free + self._answer
        else:
            step = hit
            self._drop(hit, dropped, waiting)
        previous = self._offered[-1] if self._offered else 0
        self._offered.append(step + 1)
        return step + 1 - max(began, previous + 1) + 1, reads

    def _set_up(self) -> int:
        """Take a point, bring its segment to the last stage, and return when it is there."""
        left = self._left
        clock = self._taken = max(self._taken + 1, left[0])
        for stage in range(SPAN_STAGES - 1):
            clock = left[stage] = max(clock + 1, left[stage + 1])
        return clock + 1

    def _next(self, clock: int, number: int) -> int:
        """Return when a segment is taken that is there from ``clock`` on."""
        clock = max(clock, self._columns_free)
        if number == 0 and len(self._offered) >= VERDICT_PLACES:
            clock = max(clock, self._offered[-VERDICT_PLACES] + 1)
        if self._count and len(self._freed) >= self._places:
            clock = max(clock, self._freed[-self._places])
        return clock

    def _place(self, clock: int, waiting: int) -> int:
        """Return when a column comes for which there is a place, from ``clock`` on."""
        while True:
            self._returns = sorted(given for given in self._returns if given >= clock)
            if len(self._returns) + waiting < COLUMN_TASKS:
                return clock
            if not self._returns:
                return _NEVER  # All are waiting, until the hit.
            clock = self._returns[0] + 1

    def _drop(self, hit: int, dropped: bool, waiting: list[int]) -> None:
        """Leave a path at the step ``hit``."""
        if dropped:
            self._columns_free = self._cells_free = hit + 1
            self._returns = []
        elif waiting or self._cells_free >= hit:
            self._cells_free = hit
            for there in waiting:
                self._cells_free = max(there, self._cells_free + 1)
                self._returns.append(self._cells_free)
            self._cells_free += 1
