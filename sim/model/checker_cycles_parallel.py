"""Cycles and reads of the parallel build, as its own counters give them."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from pathgene.hdl.config import Config
from pathgene.sim.model.checker import Point, TerrainModel, Verdict, segment_cells
from pathgene.sim.model.checker_kernels import check_paths


__all__ = ["parallel_cycles"]

#: Cycles from the launch of a group of cells to its addresses at the memory; from there to its
#: step, besides the latency of the memory; from the step to the verdict.
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
    """Return the segment and the cell of it that collides first."""
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
    #: Group that decides its path, by a hit or by its end.
    decides: int | None
    launched: int = 0


class _Front:
    """The stages in which points and segments wait.

    See :class:`pathgene.hdl.feasibility.parallel.segment_setup.SegmentSetup`.

    A segment is measured, waits, and is launched after the one before it, a group each cycle. The
    stages after the launch take fixed times.

    Parameters
    ----------
    config : Config
    paths : sequence of paths
    hits : sequence of (int, int) or None
        Segment and cell that end each path early.

    Attributes
    ----------
    taken : list of int
        Clock in which the first point of each path is taken.
    decided : list of int
        Clock of the step that decides each path.
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
        """Return the addresses given for ``path`` up to the cycle in which it is decided."""
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
        )  # None is the first point of a path; any other completes a segment.
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

            # With all stages full, nothing changes until the present segment has been launched.
            cycle += 1
            if left and measured and waiting:
                pause = min(left, drops[0][0] - cycle if drops else left)
                left, cycle = left - pause, cycle + pause


def _unless(segment: _Segment | None, path: int) -> _Segment | None:
    return None if segment is None or segment.path == path else segment
