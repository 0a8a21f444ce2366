"""Boards on serial ports: the kind of board that every URL without a registered scheme names."""

from __future__ import annotations

from urllib.parse import parse_qsl

from hdl.config import Config
from hdl.protocol import LINE_BITS
from host.device.schemes import BoardScheme, OpenPort, scheme_names
from host.errors import InputError


__all__ = ["SerialScheme"]


class SerialScheme(BoardScheme):
    """A serial device or any URL of pyserial, with the option ``?baud=NUMBER``.

    The baud rate defaults to that of the default configuration.

    Parameters
    ----------
    timeout_s : float
        Longest silence of a board in seconds, the time of bytes on the line apart.
    attempts : int
        Number of times that a frame is sent before the board is given up.
    """

    def __init__(self, *, timeout_s: float = 0.25, attempts: int = 12) -> None:
        self.timeout_s = timeout_s
        self.attempts = attempts

    def open(self, url: str) -> OpenPort:
        """Open the port, shared: another process may have it open."""
        import serial

        place, _, query = url.partition("?")
        options = dict(parse_qsl(query, keep_blank_values=True))
        config = Config()
        baud = options.pop("baud", str(config.clock_hz // config.clocks_per_bit))
        if options or not baud.isdigit() or int(baud) == 0:
            raise InputError(
                f"A serial board takes the option baud=NUMBER and no other, not {url!r}."
            )
        try:
            port = serial.serial_for_url(place, baudrate=int(baud), timeout=0, exclusive=None)
        except (OSError, ValueError) as error:
            simulated = ", ".join(f"{name}:" for name in scheme_names())
            raise InputError(
                f"No board can be opened at {url!r} ({error}); give {simulated}, a serial device "
                "or a URL of pyserial."
            ) from None
        # The operating system may still hold a full window of bytes for the line.
        on_line_s = LINE_BITS * config.receive_buffer / port.baudrate
        return OpenPort(port, self.timeout_s + on_line_s, self.attempts)
