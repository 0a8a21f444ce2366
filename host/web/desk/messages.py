"""Messages between the desk and its processes, which plan or fly."""

from __future__ import annotations

import contextlib
import threading
from dataclasses import dataclass
from multiprocessing.connection import Connection


__all__ = ["STOP", "Ending", "Failed", "Saved", "Sender"]

#: Message of the desk that ends a process.
STOP = "stop"


@dataclass(frozen=True)
class Ending:
    """The search has ended early and is choosing its path."""


@dataclass(frozen=True)
class Saved:
    """All files except pictures are written; ``notes`` are sentences about facts they lack."""

    notes: list[str]


@dataclass(frozen=True)
class Failed:
    """There is no result, or no file of it; the sentence says why."""

    sentence: str


class Sender:
    """Sends messages to the desk from any thread."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._lock = threading.Lock()

    def send(self, message: object) -> None:
        """Send a message; if the desk has ended, ignore that, so that the work is still saved."""
        with self._lock, contextlib.suppress(OSError):
            self._connection.send(message)
