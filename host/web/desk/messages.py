"""Messages between the desk and its processes, whether these plan or fly."""

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
    """The search has ended early, and chooses its path."""


@dataclass(frozen=True)
class Saved:
    """All files are written but pictures; ``notes`` are sentences on facts that they lack."""

    notes: list[str]


@dataclass(frozen=True)
class Failed:
    """The sentence on why there is no result, or no file of it."""

    sentence: str


class Sender:
    """Sends to the desk, from any thread.

    Parameters
    ----------
    connection : Connection
        Where to.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._lock = threading.Lock()

    def send(self, message: object) -> None:
        """Send a message; if the desk has ended, the work is finished and saved nevertheless."""
        with self._lock, contextlib.suppress(OSError):
            self._connection.send(message)
