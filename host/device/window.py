"""Bookkeeping of commands that have no answer yet: go-back-N within a credit of bytes."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field


__all__ = ["Request", "Window"]


@dataclass
class Request:
    """One command on its way.

    Attributes
    ----------
    code : int
        Code of the command.
    payloads : tuple of bytes
        Its payload, and others that may take its place, in the order they are tried.
    answer : bytes or None
        Payload of its answer, once there is one.
    """

    code: int
    payloads: tuple[bytes, ...]
    answer: bytes | None = None


@dataclass
class Window:
    """Progress of a sequence of commands, which are named by their index in it.

    Attributes
    ----------
    first : int
        Sequence number of the first command.
    confirmed : int
        Commands that the chip has executed for certain.
    cursor : int
        The next to be sent.
    sent : int
        Commands that have been sent at least once.
    flush : bool
        Whether the next frame needs a delimiter before it: one may have been lost.
    flying : deque of (int, int)
        Index and size of every frame, repeated ones too, that may still be in the chip's buffer.
        The size counts against the credit: body and CRC, bytes.
    """

    first: int
    confirmed: int = 0
    cursor: int = 0
    sent: int = 0
    flush: bool = False
    flying: deque[tuple[int, int]] = field(default_factory=deque)

    def index(self, sequence: int) -> int:
        """Return the index, next to ``confirmed``, of a sequence number."""
        ahead = (sequence - self.first - self.confirmed + 128) % 256 - 128
        return self.confirmed + ahead

    @property
    def flying_bytes(self) -> int:
        """Bytes in the chip's buffer, at most."""
        return sum(size for _, size in self.flying)

    def note_sent(self, size: int) -> None:
        """Note that the command at the cursor has been sent."""
        self.flying.append((self.cursor, size))
        self.cursor += 1
        self.sent = max(self.sent, self.cursor)
        self.flush = False

    def confirm(self, index: int) -> None:
        """Note that the chip has executed the command with this index."""
        self.confirmed = max(self.confirmed, index + 1)
        self.cursor = max(self.cursor, self.confirmed)
        if any(flying == index for flying, _ in self.flying):
            while self.flying.popleft()[0] != index:
                pass

    def go_back(self, index: int) -> None:
        """Note that the chip waits for this index and dropped a later one."""
        self.confirmed = max(self.confirmed, index)
        # The answer is to the oldest frame that is not the expected one, or to a later one.
        if any(flying != index for flying, _ in self.flying):
            while self.flying.popleft()[0] == index:
                pass
        if all(flying != index for flying, _ in self.flying):
            self._resend()

    def start_again(self) -> None:
        """Note that nothing sent so far will be answered."""
        self.flying.clear()
        self._resend()

    def _resend(self) -> None:
        self.cursor = self.confirmed
        self.flush = True
