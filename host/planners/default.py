"""The planner of a search for which none is named: the board's core decides."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pathgene.hdl.config import GeneticCore
from pathgene.host.device.boards import known_config, open_board, with_core
from pathgene.host.device.chip import Chip
from pathgene.host.errors import InputError
from pathgene.host.planners import DEFAULT, ON_PAPER_CORE, PLANNERS


__all__ = ["asks_hardware", "default_planner", "named_or_default"]


def default_planner(board: str | Chip | None = None) -> str:
    """Return the planner for the core of a board: ``ga-fpga`` on the paper core.

    In all other cases it is ``ga-chip``: without a board, with the planner core, and on a simulated
    board, which is built as its planner needs it. A simulated board has the paper core if its URL
    has parameters that only this core takes.

    Parameters
    ----------
    board : str or Chip, optional
        URL of the board, or an open one. Hardware is opened and queried.

    Raises
    ------
    InputError, JobError
        If hardware does not answer, as for :func:`pathgene.host.device.boards.open_board`.
    """
    if board is None:
        return DEFAULT
    if isinstance(board, Chip):
        config = board.config
    else:
        url = with_core(board, GeneticCore.PLANNER)
        try:
            known = known_config(url)
        except InputError:
            # An error with both cores is reported when the board is opened.
            return ON_PAPER_CORE
        if known is None:
            with open_board(url) as chip:
                known = chip.config
        config = known
    return ON_PAPER_CORE if config.paper_core else DEFAULT


def asks_hardware(planner: str | None, board: str | None) -> bool:
    """Return True if the planner is the default one, which depends on the hardware.

    Parameters
    ----------
    planner : str or None
        Name of a planner; None if not given.
    board : str or None
        URL of the board; None if not given.
    """
    return planner is None and board is not None and known_config(board) is None


def named_or_default(planner: str | None, options: Mapping[str, Any]) -> str:
    """Return ``planner``, or if it is None, the default planner for the board in ``options``.

    Parameters
    ----------
    planner : str or None
        Name of a planner.
    options : mapping
        Options in :data:`pathgene.host.options.table.OWN`; None stands for the default.

    Raises
    ------
    InputError
        If the default planner lacks a given option, or as :func:`default_planner` does.
    JobError
        As :func:`default_planner`.
    """
    if planner is not None:
        return planner
    board = options.get("board")
    name = default_planner(board)
    for option, value in options.items():
        if value is None or option in PLANNERS[name].options:
            continue
        having = [other for other, entry in PLANNERS.items() if option in entry.options]
        if having:
            where = "" if board is None else " of this board"
            raise InputError(
                f"The default planner{where}, {name}, has no option {option} "
                f"(--{option.replace('_', '-')}); name a planner that has it (--planner): "
                f"{', '.join(having)}."
            )
    return name
