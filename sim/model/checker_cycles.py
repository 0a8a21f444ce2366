"""Cycles and reads of the collision checker, as reported by its counters.

Path by path, without a simulation of each cycle: a function for each build.
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.sim.model.checker import (
    Point,
    TerrainModel,
    Verdict,
    check_path,
    segment_cells,
    to_coarse,
)
from pathgene.sim.model.checker_kernels import check_paths


__all__ = ["batch_cycles", "parallel_cycles", "two_tier_cycles"]


def two_tier_cycles(
    config: Config, terrain: TerrainModel, paths: Iterable[Sequence[Point]], count: bool = False
) -> list[tuple[int, int]]:
    """Return the cycles and reads in the verdict of every path of a queue.

    The source always has the next point, and verdicts are taken immediately; the chip is idle
    before the first path. A queue of one path is a single path.

    The model follows each segment through the stages of the walker by the cycles in which it enters
    and leaves them. The walk stops in the cycle in which a hit leaves the comparison.

    Parameters
    ----------
    paths : iterable of sequences of (int, int, int)
    """
    answer = config.memory_latency + 3  # Cycles from a visit to its step.
    places = config.count_places
    freed: list[int] = []  # First cycle in which the place of each counted segment is free again.
    results = []
    taken = 0  # Cycle in which the latest point was taken.
    measured = 0  # Cycle in which the latest segment left the first stage of the set-up,
    passed = 0  # the second stage,
    ended = 0  # and the walker.
    verdict = 0  # Cycle in which the latest verdict was offered.
    for path in paths:
        outcome = check_path(config, terrain, path, count)
        counted = {segment for segment, _, _ in outcome.entries}
        began = taken = taken + 1
        hit: int | None = None  # Cycle of the step that ends the walk.
        reads = 0
        for number, (start, stop) in enumerate(itertools.pairwise(path)):
            taken = max(taken + 1, measured)
            measured = max(taken + 1, passed)
            if number >= config.DETAILED_SEGMENTS:
                start, stop = to_coarse(config, start), to_coarse(config, stop)
            cells = segment_cells(start, stop)
            free = max(measured + 1, ended)
            if count and len(freed) >= places:
                free = max(free, freed[-places])
            if hit is not None and free >= hit:
                passed = max(measured, passed, hit) + 1
                continue
            passed, ended = free, free + cells
            if outcome.collision and not count and outcome.segment == number:
                hit = passed + (outcome.cells - reads) + answer
            if hit is not None and ended >= hit:
                cells -= ended - hit
                ended = hit + 1  # Nothing is taken in the cycle of the step.
            reads += cells
            if count:
                freed.append(ended + answer + (2 if number in counted else 1))
        offered = (ended + answer if hit is None else hit) + 1
        results.append((offered - max(began, verdict + 1) + 1, reads))
        verdict = offered
    return results


#: Cycles from the launch of a group of cells to its addresses at the memory; from there to its
#: step, not counting the latency of the memory; from the step to the verdict.
_LAUNCH_TO_READ = 3
_READ_TO_STEP = 3
_STEP_TO_VERDICT = 1


def parallel_cycles(
    config: Config, terrain: TerrainModel, paths: Sequence[Sequence[Point]], count: bool = False
) -> list[tuple[int, int]]:
    """Return ``cycles`` and ``reads`` of each path's verdict in the parallel build.

    See :func:`pathgene.sim.model.checker_cycles.batch_cycles`.
    """
    verdicts = check_paths(config, terrain, paths, count)
    hits = [
        None if count else _hit(path, verdict)
        for path, verdict in zip(paths, verdicts, strict=True)
    ]
    front = _Front(config, paths, hits)
    front.run()

    results = []
    offered = 0
    for path, decided in enumerate(front.decided):
        start = max(front.taken[path], offered + 1)
        offered = decided + _STEP_TO_VERDICT
        results.append((offered - start + 1, front.reads(path)))
    return results


def _hit(path: Sequence[Point], verdict: Verdict) -> tuple[int, int] | None:
    """Return the first colliding segment and its colliding cell."""
    if not verdict.collision:
        return None
    passed = sum(segment_cells(path[i], path[i + 1]) for i in range(verdict.segment))
    return verdict.segment, verdict.cells - passed - 1


@dataclass
class _Segment:
    path: int
    cells: int
    groups: int
    ends_path: bool
    #: The group that decides its path, by a hit or by its end.
    decides: int | None
    launched: int = 0


class _Front:
    """The stages in which points and segments wait.

    See :class:`pathgene.hdl.feasibility.parallel.segment_setup.SegmentSetup`.

    A segment is measured, waits, and is launched after the previous one, one group per cycle. The
    stages after the launch take fixed times.

    Parameters
    ----------
    paths : sequence of paths
    hits : sequence of (int, int) or None
        Segment and cell that end each path early.

    Attributes
    ----------
    taken : list of int
        Cycle in which the first point of each path is taken.
    decided : list of int
        Cycle of the step that decides each path.
    """

    def __init__(
        self,
        config: Config,
        paths: Sequence[Sequence[Point]],
        hits: Sequence[tuple[int, int] | None],
    ) -> None:
        self._lanes = config.lanes
        self._to_step = _LAUNCH_TO_READ + config.memory_latency + _READ_TO_STEP
        self._segments: list[list[_Segment]] = []
        for number, (path, hit) in enumerate(zip(paths, hits, strict=True)):
            segments = []
            for i in range(len(path) - 1):
                cells = segment_cells(path[i], path[i + 1])
                groups = -(-cells // config.lanes)
                ends = i == len(path) - 2
                decides = groups - 1 if ends and hit is None else None
                if hit is not None and hit[0] == i:
                    decides = hit[1] // config.lanes
                segments.append(_Segment(number, cells, groups, ends, decides))
            self._segments.append(segments)
        self._dropped = [hit is not None for hit in hits]
        self.taken: list[int] = []
        self.decided: list[int] = []

    def reads(self, path: int) -> int:
        """Return the number of addresses given for ``path`` until it is decided."""
        last = self.decided[path] - _LAUNCH_TO_READ
        return sum(
            min(segment.cells, self._lanes * (last - segment.launched + 1))
            for segment in self._segments[path]
            if 0 < segment.launched <= last
        )

    def run(self) -> None:
        """Launch all segments of paths that are not dropped."""
        points = deque(
            segment for segments in self._segments for segment in (None, *segments)
        )  # None stands for the first point of a path; any other point completes a segment.
        drops: deque[tuple[int, int]] = deque()  # Clock, path.
        measured: _Segment | None = None
        waiting: _Segment | None = None
        current: _Segment | None = None
        unwanted = -1
        left = 0
        cycle = 1
        while points or measured or waiting:
            dropped = -1
            if drops and drops[0][0] == cycle:
                dropped = drops.popleft()[1]
            launch = waiting is not None and left == 0
            moves = waiting is None or launch
            ready = measured is None or moves
            if launch:
                assert waiting is not None
                current, left = waiting, waiting.groups
                if current.path != dropped:
                    current.launched = cycle
                    if current.decides is not None:
                        self.decided.append(cycle + current.decides + self._to_step)
                        if self._dropped[current.path]:
                            drops.append((self.decided[-1], current.path))
            left = max(0, left - 1)
            if current is not None and current.path == dropped:
                left = 0

            entering = None
            if ready and points:
                entering = points.popleft()
                if entering is None:
                    self.taken.append(cycle)
            if dropped >= 0:
                unwanted = dropped
            waiting = _unless(measured if moves else waiting, unwanted)
            measured = _unless(entering if ready else measured, unwanted)

            # With all stages full, nothing changes until the current segment has been launched.
            cycle += 1
            if left and measured and waiting:
                pause = min(left, drops[0][0] - cycle if drops else left)
                left, cycle = left - pause, cycle + pause


def _unless(segment: _Segment | None, path: int) -> _Segment | None:
    return None if segment is None or segment.path == path else segment


def batch_cycles(
    config: Config, terrain: TerrainModel, paths: Sequence[Sequence[Point]], count: bool = False
) -> list[tuple[int, int]]:
    """Return the exact ``cycles`` and ``reads`` of each path's verdict.

    The paths are queued: the checker is offered a point in every cycle, and its verdicts and counts
    are taken immediately. A batch of one is a single path.

    ``cycles`` begin with the cycle in which the path's first point is taken or, if later, with the
    cycle after the previous verdict was offered; they end with the cycle in which the path's own
    verdict is offered. ``reads`` is the number of addresses given to the memories for the path.

    Raises
    ------
    ValueError
        See :func:`pathgene.sim.model.checker.check_path`.
    """
    cycles = two_tier_cycles if config.checker is CheckerBuild.TWO_TIER else parallel_cycles
    return cycles(config, terrain, paths, count)
