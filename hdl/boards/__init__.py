"""Real boards: pins, device, clock and configuration of each, one file per board.

A board file contains no logic, only ``CHIPS``: a :class:`pathgene.hdl.boards.board.Board` for each
kind of chip that fits on the board, the default first; :mod:`pathgene.hdl.boards.board_top`
connects the chip to the pins, :mod:`pathgene.hdl.boards.build` makes the bitstream.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING


if TYPE_CHECKING:
    from pathgene.hdl.boards.board import Board, ChipKind


__all__ = ["BOARDS", "chips_of", "find_board"]

#: Module of every board, by the name that `make bitstream BOARD=` takes.
BOARDS: Mapping[str, str] = MappingProxyType(
    {
        "ulx3s-85f": "pathgene.hdl.boards.ulx3s_85f",
        "ulx3s-45f": "pathgene.hdl.boards.ulx3s_45f",
        "ecpix5-85f": "pathgene.hdl.boards.ecpix5_85f",
        "icebreaker": "pathgene.hdl.boards.icebreaker",
        "arty-a7-100": "pathgene.hdl.boards.arty_a7_100",
    }
)


def chips_of(name: str) -> Sequence[Board]:
    """Return the board of that name with each chip that fits on it, the default first.

    Raises
    ------
    ValueError
        If there is no such board.
    """
    if name not in BOARDS:
        raise ValueError(f"Board must be one of {', '.join(BOARDS)}, not {name!r}")
    chips: Sequence[Board] = importlib.import_module(BOARDS[name]).CHIPS
    return chips


def find_board(name: str, chip: ChipKind | str | None = None) -> Board:
    """Return the board of that name, with the given kind of chip or with its default chip.

    Raises
    ------
    ValueError
        If there is no such board, or if it has no room for the chip.
    """
    chips = chips_of(name)
    for board in chips:
        if chip in (None, board.chip):
            return board
    kinds = " or ".join(board.chip for board in chips)
    raise ValueError(f"Chip of {name} must be {kinds}, for which it has room, not {chip}")
