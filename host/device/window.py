"""Commands in flight: a go-back-N window limited by a credit of bytes."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES
from pathgene.hdl.protocol.codes import Status
from pathgene.host.device.link_errors import RefusedError, taken


__all__ = ["Request", "Window", "take"]


@dataclass
class Request:
    """One command and its answer.

    Attributes
    ----------
    payloads : tuple of bytes
        Payload of the command, and alternatives in the order in which they are tried.
    answer : bytes or None
        Payload of the answer; None before it arrives.
    is_filler : bool
        The command has the number of a refused one: refusals answer that one.
    is_poll : bool
        The chip may be busy and refuse the command, which is then sent again with its number.
    is_refused : bool
        The chip has refused a poll.
    """

    code: int
    payloads: tuple[bytes, ...]
    answer: bytes | None = None
    is_filler: bool = False
    is_poll: bool = False
    is_refused: bool = False


@dataclass
class Window:
    """Progress of a sequence of commands; a command is named by its index in the sequence.

    Attributes
    ----------
    first : int
        Sequence number of the first command.
    confirmed : int
        Number of commands that the chip has certainly executed.
    cursor : int
        Index of the next command to send.
    sent : int
        Number of commands that have been sent at least once.
    flush : bool
        True if the next frame needs a delimiter before it, because one may have been lost.
    in_flight : deque of (int, int)
        Index and size of every frame that may still be in the chip's buffer, repeated frames
        included. The size, body and CRC in bytes, counts against the credit.
    """

    first: int
    confirmed: int = 0
    cursor: int = 0
    sent: int = 0
    flush: bool = False
    in_flight: deque[tuple[int, int]] = field(default_factory=deque)

    def index(self, sequence: int) -> int:
        """Return the index nearest to ``confirmed`` that has this sequence number."""
        ahead = (sequence - self.first - self.confirmed + 128) % 256 - 128
        return self.confirmed + ahead

    @property
    def bytes_in_flight(self) -> int:
        """Maximum bytes in the chip's buffer."""
        return sum(size for _, size in self.in_flight)

    def note_sent(self, size: int) -> None:
        """Note that the command at the cursor has been sent."""
        self.in_flight.append((self.cursor, size))
        self.cursor += 1
        self.sent = max(self.sent, self.cursor)
        self.flush = False

    def confirm(self, index: int) -> None:
        """Note that the chip has executed the command with this index."""
        self.confirmed = max(self.confirmed, index + 1)
        self.cursor = max(self.cursor, self.confirmed)
        if any(sent == index for sent, _ in self.in_flight):
            while self.in_flight.popleft()[0] != index:
                pass

    def go_back(self, index: int) -> None:
        """Note that the chip expects this index and has dropped a later one."""
        self.confirmed = max(self.confirmed, index)
        # The chip answered the oldest unexpected frame or a later one.
        if any(sent != index for sent, _ in self.in_flight):
            while self.in_flight.popleft()[0] == index:
                pass
        if all(sent != index for sent, _ in self.in_flight):
            self._resend()

    def start_again(self) -> None:
        """Note that no frame sent before will be answered."""
        self.in_flight.clear()
        self._resend()

    def _resend(self) -> None:
        self.cursor = self.confirmed
        self.flush = True


def take(requests: Sequence[Request], window: Window, body: bytes) -> None:
    """Record one answer of the session; late answers change nothing."""
    sequence, status = body[1:BODY_HEADER_BYTES]
    if status == Status.NO_SESSION:
        raise taken()
    index = window.index(sequence)
    if status == Status.OUT_OF_ORDER:
        if requests[0].is_refused:
            # The STATUS after the poll, whose number the chip still expects.
            raise RefusedError(requests[0].code, Status.BUSY)
        if window.confirmed <= index < window.sent:
            window.go_back(index)
    elif not 0 <= index < window.sent:
        return
    elif status == Status.OK:
        if requests[index].answer is None:
            requests[index].answer = body[BODY_HEADER_BYTES:]
        window.confirm(index)
    elif status == Status.DUPLICATE:
        # The chip has executed it before. It repeats the answer of the latest command only.
        if index < window.sent - 1:
            window.confirm(index)
    elif index >= window.confirmed and not requests[index].is_filler:
        if status == Status.BUSY and requests[index].is_poll:
            requests[index].is_refused = True
            return
        raise RefusedError(requests[index].code, status)
