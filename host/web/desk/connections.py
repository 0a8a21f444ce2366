"""Connections of the desk: their number is limited, and so is the time until a request."""

from __future__ import annotations

import asyncio
from typing import cast

from uvicorn.protocols.http.h11_impl import H11Protocol


__all__ = ["LimitedProtocol"]

#: Connections at once: of 32 tabs, each with the most that a browser opens.
_MOST = 256
#: Seconds in which a connection must have sent a request.
_SILENT_S = 10.0


class LimitedProtocol(H11Protocol):
    """HTTP of a client that must ask for something.

    A connection without a request is closed after ten seconds; the oldest of them as soon as there
    are too many connections. Who has asked for something is not disturbed.
    """

    _deadline: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take a connection, and close another where there are too many."""
        super().connection_made(cast(asyncio.Transport, transport))
        self._deadline = self.loop.call_later(_SILENT_S, transport.close)
        if len(self.connections) > _MOST:
            # The new one is among them.
            silent = {
                each._deadline.when(): each
                for each in self.connections
                if isinstance(each, LimitedProtocol) and each._deadline is not None
            }
            oldest = silent[min(silent)]
            oldest.transport.close()
            self.connections.discard(oldest)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget a connection."""
        self._heard()
        super().connection_lost(exc)

    def handle_events(self) -> None:
        """Take what has arrived."""
        super().handle_events()
        if self.headers is not None:
            self._heard()

    def _heard(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None
