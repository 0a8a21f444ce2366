"""Model of the commands of the planner core: problems, runs on them, shapes to block."""

from __future__ import annotations

import dataclasses
import functools
import threading
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from numpy.typing import NDArray

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import UNITS, Status
from pathgene.hdl.protocol.planner import (
    BLOCKS,
    COARSE_BLOCKS,
    VALUE_BITS,
    NoFlyShape,
    PathClass,
    ProblemRecord,
    no_fly_request,
    problem_request,
)
from pathgene.hdl.protocol.runs import (
    Outcome,
    RunOptions,
    guide_request,
    pack_best,
    run_request,
)
from pathgene.sim.model.checker import TerrainModel
from pathgene.sim.model.planner.run import (
    WATCHED,
    WATCHED_CYCLES,
    WATCHED_GENERATIONS,
    WATCHED_STOP,
    plan,
)
from pathgene.sim.model.planner.walk import Ground
from pathgene.sim.model.requests import expect


__all__ = ["BlockMarks", "RunningModel", "block"]


Corners = npt.NDArray[np.integer]


class BlockMarks:
    """Marks that determine which blocks a run scans, as in ``BlockMap``.

    Writing a corner marks its block; corners beyond the blocks mark none. All blocks are scanned
    the first time, and when a corner was written, or a scan begins, with a different block size
    than in the previous scan.

    Attributes
    ----------
    shift, edge : int
        The current blocks: ``2**shift`` corners along each edge, and ``edge`` blocks along each
        edge of the map.
    """

    def __init__(self) -> None:
        self.shift, self.edge = 0, COARSE_BLOCKS
        self._marks = np.zeros((BLOCKS, BLOCKS), dtype=bool)
        self._scanned: tuple[int, int] | None = None

    def write(self, x: Corners, y: Corners) -> None:
        """Mark the blocks of corners.

        Parameters
        ----------
        x, y : ndarray
            Integers that broadcast: each pair is a corner.
        """
        if x.size == 0 or y.size == 0:
            return
        if (self.shift, self.edge) != self._scanned:
            self._scanned = None
        x, y = np.broadcast_arrays(x >> self.shift, y >> self.shift)
        on_blocks = np.maximum(x, y) < self.edge
        self._marks[y[on_blocks], x[on_blocks]] = True

    def scan(self) -> int:
        """Return the number of blocks that a scan reads, and clear the marks."""
        is_known = self._scanned == (self.shift, self.edge)
        marked = int(self._marks.sum()) if is_known else self.edge**2
        self._marks[:] = False
        self._scanned = self.shift, self.edge
        return marked


def block(ground: Ground, blocked: int, shape: NoFlyShape) -> None:
    """Block the corners of ``ground`` that lie in ``shape``."""
    rows = slice(shape.first_y, shape.last_y + 1)
    columns = slice(shape.first_x, shape.last_x + 1)
    box = ground[rows, columns]
    v, u = np.indices(box.shape)
    is_inside = np.ones(box.shape, dtype=bool)
    for i, (at, east, north) in enumerate(shape.edges):
        bend_x, bend_y = (0, 0) if i else (shape.bend_x, shape.bend_y)
        is_inside &= at + (east - bend_x * u) * u + (north - bend_y * v) * v >= 0
    box[is_inside] = blocked


_NONE = Outcome([], [], [])
#: Minimum number of generations before RUN is answered, unless the run ends earlier.
_BRED_FIRST = 4000
#: Maximum seconds that a STATUS or a BEST waits for the end of a run.
_LOOK_S = 0.1


class RunningModel:
    """Executes PROBLEM, RUN, STOP, BEST, BLOCK and GUIDE.

    A run of up to 4,000 generations is over when RUN is answered. A longer run continues in a
    thread: STATUS reports it, STOP ends it, BEST is refused, and before any other command that the
    chip would refuse, the caller waits for its end with :meth:`settle`.

    Parameters
    ----------
    terrain : TerrainModel
        The map, whose cells are corners; observed from now on.

    Attributes
    ----------
    cycles, generations : int
        Totals of all runs.
    """

    def __init__(self, config: Config, terrain: TerrainModel) -> None:
        self.config = config
        self._terrain = terrain
        self._marks = BlockMarks()
        terrain.observer = self._mark
        self.record: ProblemRecord | None = None
        self._guide = np.zeros((config.max_waypoints, 3), dtype=np.int64)
        self._latest = _NONE
        self.cycles = self.generations = 0
        self._run: _Run | None = None

    @property
    def latest(self) -> Outcome:
        """Result of the latest run; after a PROBLEM, it has no paths but still a population."""
        self.settle()
        return self._latest

    def settle(self) -> None:
        """Wait for the end of a run in progress."""
        if self._run is not None:
            self._latest = self._run.result()
            self._run = None
            self.cycles += self._latest.cycles
            self.generations += self._latest.generations

    def end(self) -> None:
        """End a run in progress with its current generation."""
        if self._run is not None:
            self._run.watched[WATCHED_STOP] = 1

    def _mark(self, x: int, y: int, columns: int, rows: int) -> None:
        self._marks.write(np.arange(x, x + columns), np.arange(y, y + rows)[:, None])

    def set_problem(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a PROBLEM."""
        expect(len(payload) == problem_request(self.config).size, Status.BAD_LENGTH)
        record = ProblemRecord.unpack(self.config, payload)
        expect(record.is_valid(self.config), Status.BAD_VALUE)
        if not repeated:
            self.record = record
            self._marks.shift, self._marks.edge = record.block_shift, record.blocks
            self._latest = dataclasses.replace(self.latest, paths=[], keys=[])
        return b""

    def run(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a RUN."""
        expect(len(payload) == run_request(self.config).size, Status.BAD_LENGTH)
        try:
            options = RunOptions.unpack(self.config, payload)
        except ValueError:
            options = None
        expect(options is not None, Status.BAD_VALUE)
        assert options is not None
        if repeated:
            return b""
        expect(self.record is not None, Status.BAD_VALUE)
        assert self.record is not None
        population = self.latest.population if options.warm else None
        expect(population is None or len(population) > 0, Status.BAD_VALUE)
        self._run = _Run(
            functools.partial(
                plan,
                self.config,
                self._terrain.heights,
                self.record,
                options,
                population,
                guide=self._guide,
                marked=self._marks.scan(),
            )
        )
        while self._run.goes_on and self._run.watched[WATCHED_GENERATIONS] < _BRED_FIRST:
            self._run.wait(_LOOK_S)
        return b""

    def stop(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a STOP."""
        expect(not payload, Status.BAD_LENGTH)
        self.end()
        return b""

    def best(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a BEST."""
        expect(not payload, Status.BAD_LENGTH)
        if self._run is not None:
            self._run.wait(_LOOK_S)
            expect(not self._run.goes_on, Status.BUSY)
        bits = self.config.coordinate_bits
        packed = [
            [x | y << bits | altitude << 2 * bits for x, y, altitude in path]
            for path in self.latest.paths
        ]
        return pack_best(self.config, packed, self.latest.keys)

    def block(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a BLOCK."""
        expect(len(payload) == no_fly_request(self.config).size, Status.BAD_LENGTH)
        shape = NoFlyShape.unpack(self.config, payload)
        expect(shape.is_valid(), Status.BAD_VALUE)
        if repeated:
            return b""
        x, y = shape.first_x, shape.first_y
        columns, rows = shape.last_x - x + 1, shape.last_y - y + 1
        box = np.zeros((rows, columns), dtype=np.uint16)
        in_box = dataclasses.replace(
            shape, first_x=0, first_y=0, last_x=columns - 1, last_y=rows - 1
        )
        block(box, 1, in_box)
        drawn_y, drawn_x = np.nonzero(box)
        self._terrain.block(x, y, box != 0)
        self._marks.write(x + drawn_x, y + drawn_y)
        return b""

    def guide(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a GUIDE."""
        layout = guide_request(self.config)
        expect(len(payload) == layout.size, Status.BAD_LENGTH)
        values = layout.unpack(payload)
        expect(values["index"] < self.config.max_waypoints, Status.BAD_VALUE)
        if not repeated:
            self._guide[values["index"]] = values["x"], values["y"], values["altitude"]
        return b""

    def status(self) -> dict[str, int]:
        """Return the fields of a STATUS that belong to the run."""
        counted = ("cycles", *UNITS)
        run = self._run
        if run is not None:
            run.wait(_LOOK_S)
        if run is not None and run.goes_on:
            return dict.fromkeys(counted, 0) | {
                "generation": int(run.watched[WATCHED_GENERATIONS]) & 0xFFFFFFFF,
                "cycles": int(run.watched[WATCHED_CYCLES]) & 0xFFFFFFFF,
                "running": 1,
                "key": PathClass.VOID << VALUE_BITS,
            }
        latest = self.latest
        told = {
            "generation": latest.generations,
            "running": 0,
            "key": latest.keys[0] if latest.keys else PathClass.VOID << VALUE_BITS,
        }
        return told | {name: getattr(latest, name) & 0xFFFFFFFF for name in counted}


class _Run:
    """A run in its own thread.

    Parameters
    ----------
    work : callable
        Executes the run, given the array ``watched``.

    Attributes
    ----------
    watched : ndarray
        See :func:`pathgene.sim.model.planner.run.plan`.
    """

    def __init__(self, work: Callable[..., Outcome]) -> None:
        self.watched: NDArray[np.int64] = np.zeros(WATCHED, dtype=np.int64)
        self._work = work
        self._outcome: Outcome | None = None
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._do, daemon=True)
        self._thread.start()

    def _do(self) -> None:
        try:
            self._outcome = self._work(watched=self.watched)
        except BaseException as error:
            self._error = error

    @property
    def goes_on(self) -> bool:
        """True while the run is not over."""
        return self._thread.is_alive()

    def wait(self, seconds: float) -> None:
        """Wait for the end, at most ``seconds``."""
        self._thread.join(seconds)

    def result(self) -> Outcome:
        """Wait for the end; return the result, or raise the error of the run."""
        self._thread.join()
        if self._error is not None:
            raise self._error
        assert self._outcome is not None
        return self._outcome
