"""Model of the commands of the streaming core: problems, runs on them, shapes to be blocked."""

from __future__ import annotations

import dataclasses

import numpy as np

from hdl.config import Config
from hdl.protocol import Status
from hdl.protocol.planner import (
    VALUE_BITS,
    NoFlyShape,
    PathClass,
    ProblemRecord,
    no_fly_request,
    problem_request,
)
from hdl.protocol.runs import Outcome, RunOptions, pack_best, run_request
from sim.model.block_marks import BlockMarks
from sim.model.checker import TerrainModel
from sim.model.planner import no_fly
from sim.model.planner.run import plan
from sim.model.refusal import expect


__all__ = ["RunningModel"]

_NONE = Outcome([], [], [])


class RunningModel:
    """Executes PROBLEM, RUN, STOP, BEST and BLOCK.

    A run is over when RUN is answered, so there is never one to stop or to wait for.

    Parameters
    ----------
    config : Config
        Must have a streaming core.
    terrain : TerrainModel
        The map, of corners; observed from here on.

    Attributes
    ----------
    record : ProblemRecord or None
        The problem, if there is one.
    latest : Outcome
        Result of the latest run; without paths after a PROBLEM, but with its population.
    """

    def __init__(self, config: Config, terrain: TerrainModel) -> None:
        self.config = config
        self._terrain = terrain
        self._marks = BlockMarks()
        terrain.observer = self._mark
        self.record: ProblemRecord | None = None
        self.latest = _NONE

    def _mark(self, x: int, y: int, columns: int, rows: int) -> None:
        self._marks.write(np.arange(x, x + columns), np.arange(y, y + rows)[:, None])

    def set_problem(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a PROBLEM."""
        expect(len(payload) == problem_request(self.config).size, Status.BAD_LENGTH)
        record = ProblemRecord.unpack(self.config, payload)
        expect(record.is_valid(self.config), Status.BAD_VALUE)
        if not repeated:
            self.record = record
            self._marks.shift = record.block_shift
            self.latest = dataclasses.replace(self.latest, paths=[], keys=[])
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
        self.latest = plan(
            self.config,
            self._terrain.heights,
            self.record,
            options,
            population,
            marked=self._marks.scan(),
        )
        return b""

    def stop(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a STOP."""
        expect(not payload, Status.BAD_LENGTH)
        return b""

    def best(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a BEST."""
        expect(not payload, Status.BAD_LENGTH)
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
        no_fly.block(box, 1, in_box)
        drawn_y, drawn_x = np.nonzero(box)
        self._terrain.block(x, y, box != 0)
        self._marks.write(x + drawn_x, y + drawn_y)
        return b""

    def status(self) -> dict[str, int]:
        """Return the fields of a STATUS that belong to the run."""
        latest = self.latest
        told = {
            "generation": latest.generations,
            "running": 0,
            "key": latest.keys[0] if latest.keys else PathClass.VOID << VALUE_BITS,
        }
        counted = ("cycles", "breed", "score", "walk", "sort", "wavefront")
        return told | {name: getattr(latest, name) & 0xFFFFFFFF for name in counted}
