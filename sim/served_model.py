"""The software model at a TCP port or a terminal, for one client at a time."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import threading
import time
import tty
from typing import Self

from pathgene.host.device.socket_port import BUSY
from pathgene.sim.model.chip import Chip


__all__ = ["ServedModel"]

# See "The line" in docs/protocol.md.
_MOST_WAITING = 8
_MOST_UNSENT = 1 << 16
_IDLE_S = 1.0
_READ_BYTES = 4096
# Period at which a client that waits is compared with the client that has the board, seconds.
_LOOK_S = 0.05
_READS, _ENDS = select.POLLIN, select.POLLHUP | select.POLLERR | select.POLLRDHUP


class ServedModel:
    """A model that serves clients in a thread until it is closed.

    Competing clients have the same rules as at a served simulator. The model answers while bytes
    are passed to it, so the line is silent from each answer to the next request.

    Parameters
    ----------
    chip : Chip
        The model, which keeps its state from one client to the next.
    listen : str
        ``HOST:PORT`` to listen at; port 0 takes a free one.
    pty : bool
        Serve a pseudo terminal instead of TCP.

    Raises
    ------
    OSError
        If nothing can listen there.
    """

    def __init__(self, chip: Chip, *, listen: str, pty: bool) -> None:
        self._chip = chip
        self._client: int | None = None
        self._waiting: dict[int, float] = {}
        self._unsent = b""
        # Moments of the last answer, and of the last byte that the client took.
        self._answered_s = self._taken_s = 0.0
        self._listener: socket.socket | None = None
        self._terminal: int | None = None
        if pty:
            self._client, self._terminal = os.openpty()
            tty.setraw(self._terminal)
            os.set_blocking(self._client, False)
            self.url = os.ttyname(self._terminal)
        else:
            host, _, port = listen.rpartition(":")
            self._listener = socket.create_server((host, int(port)))
            self._listener.setblocking(False)
            self.url = f"socket://{host}:{self._listener.getsockname()[1]}"
        self._wake, self._woken = os.pipe()
        self._fault = ""
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def pid(self) -> int:
        """The process of the model, which is this one."""
        return os.getpid()

    def wait(self, timeout_s: float | None = None) -> int | None:
        """Wait for the end of the model; return its status, or None after the time-out."""
        self._thread.join(timeout_s)
        return None if self._thread.is_alive() else int(bool(self._fault))

    def log(self) -> str:
        """Return the error that ended the model."""
        return self._fault

    def close(self) -> None:
        """Disconnect all clients and end the model."""
        if self._woken >= 0:
            os.close(self._woken)
            self._woken = -1
            self._thread.join()
            self._chip.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def _run(self) -> None:
        try:
            while self._serve():
                pass
        except Exception as error:  # The command reports it.
            self._fault = f"{type(error).__name__}: {error}"
        finally:
            for number in (self._client, self._terminal, self._wake, *self._waiting):
                if number is not None:
                    os.close(number)
            if self._listener is not None:
                self._listener.close()

    def _serve(self) -> bool:
        """Wait for something to happen, and handle it; return whether to continue."""
        events = self._happened()
        if self._wake in events:
            return False
        if self._listener is not None and self._listener.fileno() in events:
            self._meet()
        for number in [each for each in self._waiting if events.get(each, 0) & _ENDS]:
            self._leave(number)
        if self._client is not None:
            self._attend(self._client, events.get(self._client, 0))
        self._seat()
        return True

    def _happened(self) -> dict[int, int]:
        poll = select.poll()
        poll.register(self._wake, _READS)
        if self._listener is not None:
            poll.register(self._listener, _READS)
        for number in self._waiting:
            poll.register(number, select.POLLRDHUP)
        if self._client is not None:
            has_room = len(self._unsent) < _MOST_UNSENT
            wanted = (_READS | select.POLLRDHUP if has_room else 0) | (
                select.POLLOUT if self._unsent else 0
            )
            poll.register(self._client, wanted)
        is_contested = bool(self._waiting) or (self._terminal is not None and bool(self._unsent))
        return dict(poll.poll(1000 * _LOOK_S if is_contested else None))

    def _meet(self) -> None:
        """Accept a client, which waits; refuse one if too many wait."""
        assert self._listener is not None
        with contextlib.suppress(OSError):
            client, _ = self._listener.accept()
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            client.setblocking(False)
            self._waiting[client.detach()] = time.monotonic()
        if len(self._waiting) > _MOST_WAITING:
            silent = [number for number in self._waiting if not _has_spoken(number)]
            self._refuse((silent or list(self._waiting))[0])

    def _attend(self, client: int, events: int) -> None:
        """Pass bytes between a client and the chip."""
        if events & _READS:
            try:
                data = os.read(client, _READ_BYTES)
            except OSError:
                data = b""
            if not data and self._terminal is None:
                self._lose()
                return
            if answer := self._chip.feed(data):
                self._unsent += answer
                self._answered_s = time.monotonic()
                for number in list(self._waiting):
                    self._refuse(number)
        elif events & _ENDS and self._terminal is None:
            self._lose()
            return
        self._send(client)

    def _send(self, client: int) -> None:
        if not self._unsent:
            self._taken_s = time.monotonic()
            return
        try:
            sent = os.write(client, self._unsent)
        except BlockingIOError:
            sent = 0
        except OSError:
            self._lose()
            return
        if sent:
            self._taken_s = time.monotonic()
        elif self._terminal is not None and time.monotonic() - self._taken_s > _IDLE_S:
            sent = len(self._unsent)  # Lost, as on a real line.
        self._unsent = self._unsent[sent:]

    def _seat(self) -> None:
        """Give the board to a client that waits, if it is free or its client is silent."""
        now_s = time.monotonic()
        spoken = [number for number in self._waiting if _has_spoken(number)]
        if self._client is not None:
            is_silent = now_s - self._answered_s > _IDLE_S
            if not (is_silent and spoken and now_s - self._waiting[spoken[0]] > _IDLE_S):
                return
            self._lose()
        if self._waiting:
            self._client = (spoken or list(self._waiting))[0]
            del self._waiting[self._client]
            self._answered_s = self._taken_s = now_s

    def _lose(self) -> None:
        """Disconnect the client that has the board."""
        assert self._client is not None
        os.close(self._client)
        self._client, self._unsent = None, b""

    def _refuse(self, number: int) -> None:
        """Disconnect a client that waits, with the reason."""
        with contextlib.suppress(OSError):
            # To close with unread bytes would reset the connection, and the text might be lost.
            while os.read(number, _READ_BYTES):
                pass
        with contextlib.suppress(OSError):
            os.write(number, BUSY)
        self._leave(number)

    def _leave(self, number: int) -> None:
        os.close(number)
        del self._waiting[number]


def _has_spoken(number: int) -> bool:
    """Return whether a client that has not left has sent bytes that are still unread."""
    poll = select.poll()
    poll.register(number, _READS | select.POLLRDHUP)
    events = dict(poll.poll(0)).get(number, 0)
    return bool(events & _READS) and not events & _ENDS
