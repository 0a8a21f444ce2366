"""Serial ports of pyserial, devices and URLs, and the scheme of boards without a registered one."""

from __future__ import annotations

import math
from urllib.parse import parse_qsl, urlsplit

from pathgene.hdl.config import LINE_BITS, Config
from pathgene.host.device.schemes import (
    MAXIMUM_PATIENCE_S,
    PATIENCE_S,
    BoardScheme,
    OpenPort,
    parse_patience,
    scheme_names,
)
from pathgene.host.device.socket_port import SocketPort
from pathgene.host.device.transport import Transport
from pathgene.host.errors import InputError
from pathgene.host.numeric import whole


__all__ = ["SerialPort", "SerialScheme"]


class SerialPort:
    """A port of pyserial as a :class:`pathgene.host.device.transport.Transport`.

    Parameters
    ----------
    url : str
        Device or URL of pyserial. It is opened in shared mode: another process may have it open.
    baud : int
        Rate of the line, bits per second.

    Raises
    ------
    OSError, ValueError
        From the constructor, if there is no such port. Every other method raises
        :class:`OSError` when the port fails.
    """

    def __init__(self, url: str, baud: int) -> None:
        import serial

        self._port = serial.serial_for_url(url, baudrate=baud, timeout=0, exclusive=None)
        self._timed_out = serial.SerialTimeoutException

    @property
    def timeout(self) -> float | None:
        """Longest wait of :meth:`read`, seconds."""
        timeout: float | None = self._port.timeout
        return timeout

    @timeout.setter
    def timeout(self, timeout_s: float | None) -> None:
        self._port.timeout = timeout_s

    @property
    def write_timeout(self) -> float | None:
        """Longest wait of :meth:`write`, seconds; None if pyserial's limit is fixed."""
        timeout: float | None = self._port.write_timeout
        return timeout

    @write_timeout.setter
    def write_timeout(self, timeout_s: float | None) -> None:
        try:
            self._port.write_timeout = timeout_s
        except NotImplementedError:
            # rfc2217:// has no such setting and ends each write after 5 s. It would reject all
            # settings now.
            self._port.write_timeout = None

    @property
    def in_waiting(self) -> int:
        """Bytes that :meth:`read` would return immediately."""
        count: int = self._port.in_waiting
        return count

    def read(self, size: int = 1) -> bytes:
        """Return ``size`` bytes, or fewer if the timeout comes first."""
        data: bytes = self._port.read(size)
        return data

    def write(self, data: bytes) -> int | None:
        """Send all of ``data``.

        Raises
        ------
        TimeoutError
            If ``write_timeout`` passes first. Some of ``data`` may have been sent.
        """
        try:
            count: int | None = self._port.write(data)
        except self._timed_out as error:
            raise TimeoutError(str(error)) from None
        return count

    def close(self) -> None:
        """Close the port."""
        self._port.close()


#: Minimum number of attempts, however short the patience is: from the fifth attempt on, the link
#: asks for shorter replies.
_MINIMUM_ATTEMPTS = 5
#: Highest baud rate that a URL may set, above the rates of all ports.
_MAXIMUM_BAUD = 1_000_000_000


class SerialScheme(BoardScheme):
    """A serial device or any URL of pyserial, with ``?baud=NUMBER&patience=SECONDS``.

    The baud rate defaults to the rate of the default configuration; the default patience is the
    same for all boards. A frame is sent again after ``timeout_s`` plus the time of its bytes on the
    line, until the patience is exhausted, but at least 4 times.

    Parameters
    ----------
    timeout_s : float
        Longest silence of a board in seconds, not counting the time of bytes on the line.
    """

    def __init__(self, *, timeout_s: float = 0.25) -> None:
        self.timeout_s = timeout_s

    def open(self, url: str) -> OpenPort:
        """Open the port; a device is shared, so another process may have it open."""
        place, _, query = url.partition("?")
        config = Config()
        options = {
            "baud": str(config.clock_hz // config.clocks_per_bit),
            "patience": str(PATIENCE_S),
        }
        known = set(options)
        options |= dict(parse_qsl(query, keep_blank_values=True))
        baud, patience_s = _whole(options["baud"]), parse_patience(options["patience"])
        if set(options) != known or baud is None or patience_s is None:
            raise InputError(
                f"A serial board takes the options baud=NUMBER (at most {_MAXIMUM_BAUD:,}) and "
                f"patience=SECONDS (at most {MAXIMUM_PATIENCE_S:,}) and no others, not {url!r}."
            )
        try:
            port = _open_port(place, baud)
        except (OSError, ValueError) as error:
            simulated = ", ".join(f"{name}:" for name in scheme_names())
            raise InputError(
                f"No board can be opened at {url!r} ({error}); give {simulated}, a serial device "
                "or a URL of pyserial."
            ) from None
        # The operating system may still buffer a full window of bytes.
        timeout_s = self.timeout_s + LINE_BITS * config.receive_buffer / baud
        attempts = max(_MINIMUM_ATTEMPTS, math.ceil(patience_s / timeout_s))
        return OpenPort(port, timeout_s, attempts)


def _whole(text: str) -> int | None:
    """Return a number above 0, or None if ``text`` is not one or is too large for a port."""
    try:
        return whole(text, _MAXIMUM_BAUD) or None
    except ValueError:
        return None


def _open_port(place: str, baud: int) -> Transport:
    if not place.startswith("socket://"):
        return SerialPort(place, baud)
    parts = urlsplit(place)
    if not parts.hostname or parts.port is None:
        raise ValueError("expected socket://HOST:PORT")
    return SocketPort((parts.hostname, parts.port))
