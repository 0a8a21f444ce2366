"""Boards of the scheme ``sim:``: a simulator runs the Verilog that the URL specifies."""

from __future__ import annotations

import dataclasses
from typing import Any
from urllib.parse import parse_qsl

from pathgene.hdl.config import Config
from pathgene.host.device.schemes import (
    CONFIG_FIELDS,
    PATIENCE_S,
    BoardScheme,
    OpenPort,
)
from pathgene.host.errors import InputError
from pathgene.host.suggestion import did_you_mean
from pathgene.sim.board import BoardOptions, SimulatedBoard, open_simulated, parse_board_url
from pathgene.sim.chip_url import PORT, chip_of
from pathgene.sim.exported import exported_verilog


__all__ = ["SCHEME", "SimulatedScheme", "start_simulated"]

#: Attempts per frame: TCP loses none, so a frame is only sent again to a board that hangs.
_ATTEMPTS = 3
#: Default patience of a URL, in seconds, by simulator; Icarus is a thousand times slower.
_PATIENCE_S = {"verilator": PATIENCE_S, "icarus": 360.0}


class SimulatedScheme(BoardScheme):
    """``sim:`` with ``port``, the fields of the configuration and the simulator's options."""

    simulated = True

    def open(self, url: str) -> OpenPort:
        """Start the board; closing the port ends it."""
        board = start_simulated(url)
        options = parse_board_url(chip_of(url)[0])
        patience_s = options.patience or _PATIENCE_S[options.sim]
        return OpenPort(board.open(ends_board=True), patience_s / _ATTEMPTS, _ATTEMPTS)

    def known_config(self, url: str) -> Config:
        """Return the configuration that the URL specifies."""
        return chip_of(url)[1]

    def serve(self, url: str, *, listen: str, pty: bool) -> SimulatedBoard:
        """Start the board and keep it running when a client leaves."""
        return start_simulated(url, listen=listen, pty=pty, keep=True)


#: The entry point ``sim`` refers to this object.
SCHEME = SimulatedScheme()


def start_simulated(url: str, **options: Any) -> SimulatedBoard:
    """Build and start the simulated board that ``url`` specifies.

    Parameters
    ----------
    **options
        Passed to :func:`pathgene.sim.board.open_simulated`: ``listen``, ``pty``, ``keep``.

    Raises
    ------
    InputError
        If an option of the URL is wrong.
    JobError
        If the board cannot be started.
    """
    rest, config = chip_of(url)
    names = [field.name for field in dataclasses.fields(BoardOptions)]
    known = [name for name in names if name not in CONFIG_FIELDS]
    for name, _ in parse_qsl(rest.partition("?")[2], keep_blank_values=True):
        if name not in known:
            raise InputError(
                f"The simulated board has no option {name!r}"
                f"{did_you_mean(name, [*known, PORT, *CONFIG_FIELDS])}; choose from "
                f"{', '.join(known)}, "
                f"{PORT} and the fields of the configuration, {', '.join(CONFIG_FIELDS)}."
            )
    return open_simulated(
        rest,
        lambda divisor: exported_verilog("chip", config.replace(clocks_per_bit=divisor)),
        top="chip",
        clocks_per_bit=config.clocks_per_bit,
        **options,
    )
