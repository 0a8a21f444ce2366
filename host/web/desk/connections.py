"""Connections of the desk: their number is limited, and so is the time in which they idle."""

from __future__ import annotations

import asyncio
from typing import cast

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol


__all__ = ["LimitedProtocol"]

#: Connections at once: of 32 tabs, each with the maximum that a browser opens.
_MOST = 256
#: Seconds in which an idle connection must have sent a request.
_IDLE_S = 10.0


class LimitedProtocol(H11Protocol):
    """HTTP of a client that must ask for something.

    A connection is idle until it has sent a whole head of a request, and again once that is
    answered. Idle, it is closed after ten seconds; the oldest of them as soon as there are too many
    connections. A connection that waits for an answer, or is a WebSocket, is not disturbed.
    """

    _deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take a connection, and close another where there are too many."""
        super().connection_made(cast(asyncio.Transport, transport))
        self._watch()
        if len(self.connections) > _MOST:
            # The new one is among them.
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
        """Take the bytes that have arrived."""
        super().handle_events()
        self._watch()

    def on_response_complete(self) -> None:
        """End an answer."""
        super().on_response_complete()
        self._watch()

    def _watch(self) -> None:
        """Give an idle connection its deadline, which bytes of a next request leave as it is."""
        if self.conn.our_state is not h11.IDLE:
            self._forget()
        elif self._deadline is None:
            self._deadline = self.loop.call_later(_IDLE_S, self.transport.close)

    def _forget(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None
