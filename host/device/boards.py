"""Boards by URL: the software model, the simulated board, or hardware on any serial port."""

from __future__ import annotations

import dataclasses
import importlib
from typing import TYPE_CHECKING, Any
from urllib.parse import parse_qsl, urlencode

from hdl.config import Config
from host.device.chip import Chip
from host.device.link import Link, LinkTimeoutError
from host.errors import InputError


if TYPE_CHECKING:
    from sim.board import SimulatedBoard

__all__ = ["known_config", "open_board", "split_config", "start_simulated"]

_FIELDS = tuple(field.name for field in dataclasses.fields(Config))
#: UART divisor of simulated boards: as few clocks as the receiver allows, so that bytes are cheap.
_SIMULATED_CLOCKS_PER_BIT = 4
#: Bits of a byte on the line: start, eight data bits, stop.
_LINE_BITS = 10
#: Longest silence of a board, in seconds, before a frame is sent again, and how often it is sent
#: before the board is given up.
_PATIENCE = {"model": (0.01, 12), "sim": (5.0, 3), "icarus": (120.0, 3), "serial": (0.25, 12)}


def open_board(url: str) -> Chip:
    """Open the board at ``url``.

    Parameters
    ----------
    url : str
        ``model:``; ``sim:`` or ``sim:?sim=icarus``; a serial device; any URL of pyserial.
        ``model:`` and ``sim:`` take any field of :class:`hdl.config.Config` as an option, as in
        ``sim:?max_waypoints=20``; a serial port takes ``?baud=``, which defaults to the
        configuration's divisor at its clock.

    Raises
    ------
    InputError
        If there is no such device, an option is wrong, nothing answers, or what answers is of
        another protocol version or build.
    JobError
        If a simulated board cannot be started.
    """
    scheme, colon, _ = url.partition(":")
    if colon and scheme == "model":
        port = _open_model(url)
        timeout_s, attempts = _PATIENCE["model"]
    elif colon and scheme == "sim":
        board = start_simulated(url)
        port = _OwnedPort(board)
        is_slow = board.program.simulator == "icarus"
        timeout_s, attempts = _PATIENCE["icarus" if is_slow else "sim"]
    else:
        port = _open_serial(url)
        timeout_s, attempts = _PATIENCE["serial"]
        # What the host's system buffers of a full window is still to go over the line.
        timeout_s += _LINE_BITS * Config().receive_buffer / port.baudrate
    try:
        return Chip(Link(port, timeout_s=timeout_s, attempts=attempts))
    except LinkTimeoutError:
        port.close()
        raise InputError(
            f"Nothing answers at {url!r} as a board would; check the address, the baud rate and "
            "that the board is configured."
        ) from None
    except BaseException:
        port.close()
        raise


def split_config(url: str, default: Config) -> tuple[str, Config]:
    """Take the fields of the configuration out of the query of ``url``.

    Returns
    -------
    tuple of (str, Config)
        The URL without them, and ``default`` with them.

    Raises
    ------
    InputError
        If a value breaks a rule of the configuration.
    """
    place, _, query = url.partition("?")
    changes: dict[str, object] = {}
    rest = []
    for name, value in parse_qsl(query, keep_blank_values=True):
        if name in _FIELDS:
            changes[name] = int(value) if value.isascii() and value.isdigit() else value
        else:
            rest.append((name, value))
    try:
        config = default.replace(**changes)
    except (TypeError, ValueError) as error:
        raise InputError(f"{error}; see the options in {url!r}.") from None
    return (f"{place}?{urlencode(rest)}" if rest else place), config


def known_config(url: str) -> Config | None:
    """Return the configuration that the board at ``url`` will have, if the URL alone says it.

    Raises
    ------
    InputError
        If a value breaks a rule of the configuration.
    """
    return _split_simulated(url)[1] if url.startswith(("model:", "sim:")) else None


def _split_simulated(url: str) -> tuple[str, Config]:
    return split_config(url, Config(clocks_per_bit=_SIMULATED_CLOCKS_PER_BIT))


def start_simulated(url: str, **options: Any) -> SimulatedBoard:
    """Build and start the simulated board that ``url`` names.

    Parameters
    ----------
    url : str
        As for :func:`open_board`.
    **options
        Passed to :func:`sim.board.open_simulated`: ``listen``, ``pty``, ``keep``.
    """
    # The host runs without the simulator's package, except to simulate.
    board = importlib.import_module("sim.board")
    exported = importlib.import_module("sim.exported")
    rest, config = _split_simulated(url)
    known = [name for name in board.BoardOptions.__dataclass_fields__ if name not in _FIELDS]
    for name, _ in parse_qsl(rest.partition("?")[2], keep_blank_values=True):
        if name not in known:
            raise InputError(
                f"The simulated board has no option {name!r}; choose from {', '.join(known)} and "
                f"the fields of the configuration, {', '.join(_FIELDS)}."
            )
    simulated: SimulatedBoard = board.open_simulated(
        rest,
        lambda divisor: exported.exported_verilog(
            "planner", config.replace(clocks_per_bit=divisor)
        ),
        top="planner",
        clocks_per_bit=config.clocks_per_bit,
        **options,
    )
    return simulated


class _OwnedPort:
    """The port of a simulated board that ends with it."""

    def __init__(self, board: SimulatedBoard) -> None:
        self._board = board
        self._port = board.open()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._port, name)

    def __setattr__(self, name: str, value: Any) -> None:
        if name in ("_board", "_port"):
            object.__setattr__(self, name, value)
        else:
            setattr(self._port, name, value)

    def close(self) -> None:
        """Hang up and end the simulator."""
        self._port.close()
        self._board.close()


def _open_model(url: str) -> Any:
    chip = importlib.import_module("sim.model.chip")
    port = importlib.import_module("sim.model.port")
    rest, config = _split_simulated(url)
    if rest != "model:":
        raise InputError(
            f"The model takes only fields of the configuration, not {rest!r}; they are "
            f"{', '.join(_FIELDS)}."
        )
    return port.ModelPort(chip.ChipModel(config))


def _open_serial(url: str) -> Any:
    import serial

    place, _, query = url.partition("?")
    options = dict(parse_qsl(query, keep_blank_values=True))
    default = Config()
    baud = options.pop("baud", str(default.clock_hz // default.clocks_per_bit))
    if options or not baud.isdigit() or int(baud) == 0:
        raise InputError(f"A serial board takes the option baud=NUMBER and no other, not {url!r}.")
    try:
        return serial.serial_for_url(place, baudrate=int(baud), timeout=0, exclusive=None)
    except (OSError, ValueError) as error:
        raise InputError(
            f"No board can be opened at {url!r} ({error}); give model:, sim:, a serial device "
            "or a URL of pyserial."
        ) from None
