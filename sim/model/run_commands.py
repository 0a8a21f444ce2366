"""Model of the commands of the streaming core: problems, and runs on them."""

from __future__ import annotations

from hdl.config import Config
from hdl.protocol import Status
from hdl.protocol.planner import VALUE_BITS, PathClass, ProblemRecord, problem_request
from hdl.protocol.runs import Outcome, RunOptions, pack_best, run_request
from sim.model.checker import TerrainModel
from sim.model.planner.run import plan
from sim.model.refusal import expect


__all__ = ["RunningModel"]

_NONE = Outcome([], [], [])


class RunningModel:
    """Executes PROBLEM, RUN, STOP and BEST.

    A run is over when RUN is answered, so there is never one to stop.

    Parameters
    ----------
    config : Config
        Must have a streaming core.
    terrain : TerrainModel
        The map, of corners.

    Attributes
    ----------
    latest : Outcome
        Result of the latest run; no path after a PROBLEM.
    """

    def __init__(self, config: Config, terrain: TerrainModel) -> None:
        self.config = config
        self._terrain = terrain
        self._record: ProblemRecord | None = None
        self.latest = _NONE

    def set_problem(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a PROBLEM."""
        expect(len(payload) == problem_request(self.config).size, Status.BAD_LENGTH)
        record = ProblemRecord.unpack(self.config, payload)
        expect(record.is_valid(self.config), Status.BAD_VALUE)
        if not repeated:
            self._record, self.latest = record, _NONE
        return b""

    def run(self, payload: bytes, repeated: bool) -> bytes:
        """Execute a RUN."""
        expect(len(payload) == run_request(self.config).size, Status.BAD_LENGTH)
        expect(self._record is not None, Status.BAD_VALUE)
        assert self._record is not None
        try:
            options = RunOptions.unpack(self.config, payload)
        except ValueError:
            options = None
        expect(options is not None, Status.BAD_VALUE)
        assert options is not None
        if not repeated:
            self.latest = plan(self.config, self._terrain.heights, self._record, options)
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

    def status(self) -> dict[str, int]:
        """Return the fields of a STATUS that belong to the run."""
        latest = self.latest
        return {
            "generation": latest.generations,
            "running": 0,
            "cycles": latest.cycles & 0xFFFFFFFF,
            "key": latest.keys[0] if latest.keys else PathClass.VOID << VALUE_BITS,
        }
