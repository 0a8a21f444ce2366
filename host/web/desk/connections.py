"""Connections of the desk, limited in number and idle time."""

from __future__ import annotations

import asyncio
from typing import cast

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol


__all__ = ["LimitedProtocol"]

#: Maximum simultaneous connections: 32 tabs, each with the maximum number that a browser opens.
_MOST = 256
#: Seconds within which an idle connection must send a request.
_IDLE_S = 10.0


class LimitedProtocol(H11Protocol):
    """HTTP protocol that closes connections without requests.

    A connection is idle until it has sent the complete head of a request, and again once the
    request is answered. An idle connection is closed after ten seconds; if there are too many
    connections, the oldest idle one is closed immediately. A connection that waits for an answer,
    or is a WebSocket, is not disturbed.
    """

    _deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Accept a connection, and close another one if there are too many."""
        super().connection_made(cast(asyncio.Transport, transport))
        self._watch()
        if len(self.connections) > _MOST:
            # The new one may be among them.
            idle = {
                each._deadline.when(): each
                for each in self.connections
                if isinstance(each, LimitedProtocol) and each._deadline is not None
            }
            oldest = idle[min(idle)]
            oldest.transport.close()
            self.connections.discard(oldest)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget a connection."""
        super().connection_lost(exc)
        self._forget()

    def handle_events(self) -> None:
        """Handle the bytes that have arrived."""
        super().handle_events()
        self._watch()

    def on_response_complete(self) -> None:
        """End an answer."""
        super().on_response_complete()
        self._watch()

    def _watch(self) -> None:
        """Set the deadline of an idle connection; bytes of the next request do not extend it."""
        if self.conn.our_state is not h11.IDLE:
            self._forget()
        elif self._deadline is None:
            self._deadline = self.loop.call_later(_IDLE_S, self.transport.close)

    def _forget(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None
