"""Chips at the far end of a faulty line: the software model, and Verilog in Verilator."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path

from pathgene.hdl.config import CheckerBuild, Config, GeneticCore
from pathgene.sim.exported import exported_verilog
from pathgene.sim.harness.program import VerilatedProgram
from pathgene.sim.model.chip import Chip
from tools.chips import SMALL
from tools.faults.line import ChipOnLine


_MAIN = Path(__file__).parents[2] / "sim" / "harness" / "chip_main.cpp"

#: Clock of a Verilated chip in virtual time, slow because every silence is simulated.
CLOCK_HZ = 1e6


class Board(StrEnum):
    """Board that a session talks to."""

    MODEL = "model:"
    SIM = "sim:"


#: Chips by name: the paper core with its checker, small or with the usual population, and the
#: planner core.
CHIPS = {
    "paper": SMALL.replace(checker=CheckerBuild.TWO_TIER, lanes=1),
    "paper, 32 paths": Config(map_size=64, coarse_factor=8, altitude_bits=8),
    "planner": SMALL.replace(
        max_waypoints=8,
        map_size=64,
        altitude_bits=9,
        lanes=4,
        receive_buffer=512,
        checker=CheckerBuild.PARALLEL,
        core=GeneticCore.PLANNER,
    ),
}


#: Bytes of the longest frame that a chip's short answers need, by the chip: an answer to INFO, two
#: paths, and the results of two paths.
ANSWER_BYTES = {"paper": 64, "paper, 32 paths": 256}

#: Chips whose sessions would simulate too many cycles in Verilog.
_LARGE = {"paper, 32 paths"}


def chip_names(board: Board) -> list[str]:
    """Return the chips that are tested on a kind of board."""
    return [name for name in CHIPS if board is Board.MODEL or name not in _LARGE]


@contextmanager
def chip_on_line(board: Board, chip: str) -> Iterator[ChipOnLine]:
    """Start a chip."""
    if board is Board.MODEL:
        yield ModelOnLine(CHIPS[chip])
        return
    with VerilatedOnLine(CHIPS[chip].replace(clocks_per_bit=4)) as verilated:
        yield verilated


class ModelOnLine:
    """The software model, which answers immediately.

    Parameters
    ----------
    config : Config
        Configuration of the chip.
    """

    def __init__(self, config: Config) -> None:
        self._config = config
        self._model = Chip(config)

    def feed(self, data: bytes, reset: int | None = None) -> bytes:
        """Receive bytes; see :class:`tools.faults.line.ChipOnLine`."""
        if reset is None:
            return self._model.feed(data)
        if reset % 2:
            self._model.feed(data)
        self._model.close()
        # The memories of a real chip would keep their contents, but nobody may rely on that.
        self._model = Chip(self._config)
        return b""

    def wait(self, seconds: float) -> tuple[bytes, float]:
        """Let time pass."""
        return b"", seconds

    def paths(self) -> list[list[int]] | None:
        """Return the population; see :class:`tools.faults.line.ChipOnLine`."""
        return self._model.core.paths if self._config.paper_core else None

    def has_run(self) -> bool:
        """Return whether the planner core has run; see :class:`tools.faults.line.ChipOnLine`."""
        return self._model.running is not None and self._model.running.generations > 0

    def memory(self) -> bytes:
        """Return the map and the population; see :class:`tools.faults.line.ChipOnLine`."""
        chip = self._model
        map_bytes = chip.checking.terrain.heights.tobytes() if chip.checking else b""
        return map_bytes + repr(chip.core.paths if self._config.paper_core else "").encode()


class VerilatedOnLine(VerilatedProgram):
    """The Verilog of a chip, simulated by Verilator in another process; it counts ``cycles``.

    ``verilog`` is another chip than the exported one; with ``coverage``, the chip counts.
    """

    def __init__(
        self, config: Config, *, verilog: str | None = None, coverage: bool = False
    ) -> None:
        self.cycles = 0
        text = exported_verilog("chip", config) if verilog is None else verilog
        super().__init__(text, "chip", _MAIN, str(config.clocks_per_bit), coverage=coverage)

    def feed(self, data: bytes, reset: int | None = None) -> bytes:
        """Receive bytes; see :class:`tools.faults.line.ChipOnLine`."""
        self.send(1, len(data), data)
        sent = self._sent()[0]
        if reset is None:
            return sent
        self.send(3, reset)
        return sent + self._sent()[0]

    def wait(self, seconds: float) -> tuple[bytes, float]:
        """Let time pass."""
        self.send(2, round(seconds * CLOCK_HZ))
        sent, cycles = self._sent()
        return sent, cycles / CLOCK_HZ

    def paths(self) -> None:
        """Return nothing: the memories of the Verilog are not read."""
        return

    def has_run(self) -> bool:
        """Return nothing that speaks against the host."""
        return False

    def memory(self) -> bytes:
        """Return nothing: the memories of the Verilog are not read."""
        return b""

    def write_coverage(self, path: Path) -> None:
        """Write what a chip with ``coverage`` has counted."""
        name = str(path.resolve()).encode()
        self.send(4, len(name), name)
        self._sent()

    def _sent(self) -> tuple[bytes, int]:
        """Return the bytes that the chip has sent, and the cycles elapsed."""
        size, cycles = self.receive(2).tolist()
        self.cycles += cycles
        return self.receive_bytes(size), cycles
