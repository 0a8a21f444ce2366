"""Board URLs of the form ``sim:?name=value&...``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import get_args
from urllib.parse import parse_qsl

from pathgene.host.device.schemes import MAXIMUM_PATIENCE_S, parse_patience
from pathgene.host.errors import InputError
from pathgene.host.numeric import whole
from pathgene.sim.board.programs import Simulator


__all__ = ["BoardOptions", "parse_board_url"]


@dataclass(frozen=True)
class BoardOptions:
    """Options of the simulated board in a URL.

    Parameters
    ----------
    clocks_per_bit : int, optional
        UART divisor of the chip to build, cycles, 4..65535; None leaves it to the caller.
    idle_clocks : int, optional
        Cycles at full speed after the last activity, 0 or more; None: the simulator's default.
    trace : Path, optional
        VCD file to write.
    patience : float, optional
        Seconds without an answer after which the host gives up on the board; None: the simulator's
        default. Clients of a served board set their own.
    """

    sim: Simulator = "verilator"
    clocks_per_bit: int | None = None
    idle_clocks: int | None = None
    trace: Path | None = None
    patience: float | None = None


def parse_board_url(url: str) -> BoardOptions:
    """Return the options in ``sim:`` or ``sim:?sim=icarus&clocks_per_bit=8&trace=FILE``.

    Raises
    ------
    InputError
        If the URL has the wrong form, or an option is unknown, given twice or has a wrong value.
    """
    scheme, colon, rest = url.partition(":")
    path, _, query = rest.partition("?")
    if scheme != "sim" or not colon or path:
        raise InputError(f"A simulated board is given as sim: or sim:?sim=icarus, not {url!r}.")
    pairs = parse_qsl(query, keep_blank_values=True)
    options = dict(pairs)
    names = list(BoardOptions.__dataclass_fields__)
    for name, _ in pairs:
        if name not in names:
            raise InputError(
                f"The simulated board has no option {name!r}; choose from {', '.join(names)}."
            )
    if len(options) != len(pairs):
        raise InputError(f"Each option of the simulated board may be given once only, in {url!r}.")
    trace = options.get("trace")
    if trace == "":
        raise InputError("Option trace of the simulated board must be a file name, not ''.")
    return BoardOptions(
        sim=_simulator(options.get("sim", "verilator")),
        clocks_per_bit=_integer(options, "clocks_per_bit", 4, 65535),
        idle_clocks=_integer(options, "idle_clocks", 0, 2**63),
        trace=None if trace is None else Path(trace),
        patience=_patience(options),
    )


def _simulator(text: str) -> Simulator:
    for name in get_args(Simulator):
        if text == name:
            simulator: Simulator = name
            return simulator
    raise InputError(
        f"Option sim of the simulated board must be verilator or icarus, not {text!r}."
    )


def _patience(options: dict[str, str]) -> float | None:
    text = options.get("patience")
    if text is None:
        return None
    seconds = parse_patience(text)
    if seconds is None:
        raise InputError(
            "Option patience of the simulated board must be a number of seconds above 0, at most "
            f"{MAXIMUM_PATIENCE_S:,}, not {text!r}."
        )
    return seconds


def _integer(options: dict[str, str], name: str, minimum: int, maximum: int) -> int | None:
    text = options.get(name)
    if text is None:
        return None
    try:
        if (value := whole(text, maximum)) >= minimum:
            return value
    except ValueError:
        pass
    raise InputError(
        f"Option {name} of the simulated board must be an integer from {minimum} to {maximum}, "
        f"not {text!r}."
    )
