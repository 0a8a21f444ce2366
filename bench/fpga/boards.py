"""The whole chip on every board, and with more and fewer lanes."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

from bench.feasibility import cells_per_cycle
from bench.fpga.job import CELLS, LIMIT_S, Job, Table, chip_clock, digest_of, used, without_names
from pathgene.hdl.boards import BOARDS, chips_of, find_board
from pathgene.hdl.boards.board import Board, ChipKind
from pathgene.hdl.boards.build import prepare, try_seeds
from pathgene.hdl.boards.ecp5 import floor_plan
from pathgene.hdl.boards.route import Routed
from tools.netlist import Netlist


#: Families that can be placed and routed here.
_FAMILIES = ("ecp5", "ice40")
#: Boards with the full design, and the numbers of lanes to try.
_LANES_BOARDS = ("ulx3s-85f", "ecpix5-85f")
_LANES = (4, 8, 16)


class _ChipJob(Job):
    """A chip on a board, routed with one seed, at whatever clock the router reaches."""

    @property
    @abstractmethod
    def board(self) -> Board:
        """The board with its chip."""

    def prepare(self, folder: Path) -> str:
        """Write the sources; see :class:`~bench.fpga.job.Job`."""
        commands = prepare(self.board, folder)
        netlist = Netlist.read(folder / "chip.v", "chip")
        script = (folder / "chip.ys").read_text(encoding="utf-8")
        return digest_of(netlist, without_names(script, netlist), commands, self.board.seed)

    def route(self, folder: Path) -> Routed:
        """Synthesize and route the chip unless that has already been done there."""
        return try_seeds(self.board, folder, seeds=1, limit_s=LIMIT_S)[0]


def device_of(platform: Any) -> str:
    """Return the device of an Amaranth platform with its speed grade; an iCE40 has none."""
    return "-".join(filter(None, (platform.device, getattr(platform, "speed", None))))


@dataclass(frozen=True)
class _BoardJob(_ChipJob):
    """A chip of a board, built as by ``make bitstream``."""

    name_of_board: str
    chip: ChipKind

    @property
    def board(self) -> Board:
        """The board as its file describes it."""
        return find_board(self.name_of_board, self.chip)

    @property
    def folder(self) -> str:
        """See :class:`~bench.fpga.job.Job`."""
        return self.name.replace(", ", "-")

    def measure(self, folder: Path) -> dict[str, Any]:
        """Route it; see :class:`~bench.fpga.job.Job`."""
        platform, routed = self.board.platform(), self.route(folder)
        achieved, asked = chip_clock(routed)
        return {
            "device": device_of(platform),
            **used(routed, _family(self.board)),
            "asked, MHz": asked,
            "routed, MHz": achieved,
            "seed": routed.seed,
        }


@dataclass(frozen=True)
class _LanesJob(_ChipJob):
    """The full design with a number of lanes."""

    name_of_board: str
    lanes: int

    @property
    def board(self) -> Board:
        """The board with these lanes and their floor plan."""
        board = find_board(self.name_of_board, ChipKind.PAPER)
        sizes = board.sizes.replace(lanes=self.lanes)
        overrides = {**board.overrides, "script_after_synth": floor_plan(sizes)}
        return replace(board, sizes=sizes, overrides=overrides)

    @property
    def folder(self) -> str:
        """See :class:`~bench.fpga.job.Job`."""
        if self.lanes == find_board(self.name_of_board, ChipKind.PAPER).sizes.lanes:
            return self.name_of_board
        return f"{self.name_of_board}-{self.lanes}-lanes"

    def measure(self, folder: Path) -> dict[str, Any]:
        """Route it; see :class:`~bench.fpga.job.Job`."""
        routed, rate = self.route(folder), cells_per_cycle(self.board.sizes)
        clock = chip_clock(routed)[0]
        return {
            **used(routed, _family(self.board)),
            "routed, MHz": clock,
            "cells per cycle": rate,
            "cells per microsecond": clock * rate,
        }


def board_jobs() -> Iterator[Job]:
    """Yield a row for each chip of each board whose tools are in the package index."""
    return (
        _BoardJob(BOARDS_TABLE.name, name, board.name, board.chip) for name, board in _CHIPS.items()
    )


def lanes_jobs() -> Iterator[Job]:
    """Yield a row for each board with the full design and each number of lanes."""
    return (
        _LanesJob(LANES_TABLE.name, _lanes_name(board, lanes), board, lanes)
        for board, lanes in product(_LANES_BOARDS, _LANES)
    )


def _family(board: Board) -> str:
    return str(getattr(board.platform(), "family", "")).lower()


def _lanes_name(board: str, lanes: int) -> str:
    return f"{board}, {lanes} lanes"


def _chip_name(board: Board) -> str:
    """Return the name of a row; for the chip with the paper core, it is only the board's name."""
    return board.name if board.chip is ChipKind.PAPER else f"{board.name}, {board.chip}"


_ROUTED_BOARDS = [name for name in BOARDS if _family(find_board(name)) in _FAMILIES]
#: The chips with the paper core first.
_CHIPS = {
    _chip_name(board): board
    for kind in (ChipKind.PAPER, ChipKind.PLANNER)
    for name in _ROUTED_BOARDS
    for board in chips_of(name)
    if board.chip is kind
}
BOARDS_TABLE = Table(
    name="boards",
    title="Boards",
    columns=("chip", "device", *CELLS, "asked, MHz", "routed, MHz", "seed"),
    order=tuple(_CHIPS),
    notes=[
        "The chip of `make bitstream BOARD=... CHIP=planner`, or of `CHIP=paper` where the row has "
        "only the name of the board, with the first seed. Block RAMs: of 18 kbit on ECP5; of 4 and "
        "256 kbit, added up, on iCE40, whose logic cells, counted as LUTs, have the flip-flops. "
        "Not routed, because their tools are not in the package index: "
        f"{', '.join(name for name in BOARDS if name not in _ROUTED_BOARDS)}."
    ],
)
LANES_TABLE = Table(
    name="lanes",
    title="Lanes and clock",
    columns=("chip", *CELLS, "routed, MHz", "cells per cycle", "cells per microsecond"),
    order=[_lanes_name(board, lanes) for board, lanes in product(_LANES_BOARDS, _LANES)],
    notes=[
        "The chip of `make bitstream CHIP=paper`, with these lanes, one seed. Cells per cycle is "
        "the sustained rate over open ground of `make bench BENCH=feasibility`. Paper: about 100 "
        "cells per microsecond."
    ],
)
