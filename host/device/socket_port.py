"""A serial port over a TCP connection: to a simulated board, or to a server of serial ports."""

from __future__ import annotations

import array
import contextlib
import fcntl
import select
import socket
import termios
import time
from collections.abc import Callable
from typing import Self

from pathgene.host.device.link import LinkError


__all__ = ["BUSY", "SocketPort"]

#: The only bytes that a simulated board sends to a client while another client uses it: see
#: sim/board/bridge.hpp.
BUSY = b"busy: another client uses this board\n"
#: Longest wait for a connection, seconds.
_CONNECTION_S = 10.0


class SocketPort:
    """The methods of :class:`serial.Serial` that a link uses, over TCP.

    It differs from pyserial's ``socket://``: it knows the number of waiting bytes, reads and writes
    with one system call, and says that a simulated board is in use by another client.

    Parameters
    ----------
    timeout : float or None
        Longest wait of :meth:`read`, seconds; None waits without limit, 0 does not wait.
        The attribute ``write_timeout`` limits :meth:`write`; initially there is no limit.
    explain : Callable[[], str], optional
        Called when the peer has disconnected; returns the message of the error.

    Raises
    ------
    OSError
        From the constructor, if there is no connection to ``address``.
    LinkError
        From any method, if the peer has disconnected, or the board is in use by another client.
    """

    def __init__(
        self,
        address: tuple[str, int],
        *,
        timeout: float | None = 1.0,
        explain: Callable[[], str] | None = None,
        on_close: Callable[[], object] | None = None,
    ) -> None:
        self.timeout = timeout
        self.write_timeout: float | None = None
        self._name = f"socket://{address[0]}:{address[1]}"
        self._explain = explain
        self._on_close = on_close
        self._socket = socket.create_connection(address, timeout=_CONNECTION_S)
        self._first = b""  # The first bytes received, enough to recognize that the board is in use.
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.setblocking(False)

    @property
    def is_open(self) -> bool:
        """True until :meth:`close` is called."""
        return self._socket.fileno() >= 0

    @property
    def in_waiting(self) -> int:
        """Bytes that :meth:`read` would return immediately."""
        count = array.array("i", [0])
        fcntl.ioctl(self._socket, termios.FIONREAD, count)
        return count[0]

    def read(self, size: int = 1) -> bytes:
        """Return ``size`` bytes, or fewer if the timeout comes first."""
        deadline = None if self.timeout is None else time.monotonic() + self.timeout
        received = bytearray()
        while len(received) < size:
            try:
                part = self._socket.recv(size - len(received))
            except BlockingIOError:
                if not self._wait(read=True, deadline=deadline):
                    break
                continue
            except OSError as error:
                raise self._lost(error) from None
            if not part:
                raise self._lost(None)
            received += part
            if len(self._first) <= len(BUSY):
                self._first += part
        return bytes(received)

    def write(self, data: bytes | bytearray | memoryview) -> int:
        """Send all of ``data`` and return its length.

        Raises
        ------
        TimeoutError
            If ``write_timeout`` passes first. Some of ``data`` may have been sent.
        """
        limit = self.write_timeout
        deadline = None if limit is None else time.monotonic() + limit
        rest = memoryview(data).cast("B")
        total = len(rest)
        while rest:
            try:
                rest = rest[self._socket.send(rest) :]
            except BlockingIOError:
                if not self._wait(read=False, deadline=deadline):
                    raise TimeoutError(
                        f"The board at {self._name} took no more bytes for {limit:g} s"
                    ) from None
            except OSError as error:
                raise self._lost(error) from None
        return total

    def close(self) -> None:
        """Close the connection. A second call does nothing."""
        self._socket.close()
        if self._on_close is not None:
            self._on_close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _wait(self, *, read: bool, deadline: float | None) -> bool:
        poll = select.poll()
        poll.register(self._socket, select.POLLIN if read else select.POLLOUT)
        left = None if deadline is None else deadline - time.monotonic()
        if left is not None and left <= 0:
            return False
        return bool(poll.poll(None if left is None else left * 1000))

    def _lost(self, error: OSError | None) -> LinkError:
        if self._in_use():
            return LinkError(
                f"The board at {self._name} is in use by another client: try again when that has "
                "left."
            )
        if self._explain is not None:
            return LinkError(self._explain())
        reason = "it closed the connection" if error is None else str(error)
        return LinkError(
            f"The board at {self._name} is gone: {reason}; it has ended, or another client has "
            "taken it after a second without bytes."
        )

    def _in_use(self) -> bool:
        """Return whether the board has sent that it is in use, considering unread bytes too."""
        with contextlib.suppress(OSError):
            while len(self._first) <= len(BUSY) and (part := self._socket.recv(len(BUSY))):
                self._first += part
        return self._first == BUSY
