"""A line with faults between a host and a chip, in virtual time."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from pathgene.hdl.protocol.codec import DELIMITER
from tools.faults.watch import Watch


class HangError(BaseException):
    """The host waits although it should have given up, or works forever."""


class Way(StrEnum):
    """Direction of bytes on the line."""

    TO_BOARD = "to board"
    FROM_BOARD = "from board"


class LineFault(StrEnum):
    """Fault of a byte, of its frame, or of the board."""

    DROP = "drop"
    FLIP = "flip"
    INSERT = "insert"
    REPEAT = "repeat"
    #: Random bytes before the byte, ``value`` of them.
    NOISE = "noise"
    #: The frame does not arrive.
    LOSE_FRAME = "lose frame"
    #: The frame arrives twice.
    REPEAT_FRAME = "repeat frame"
    #: The delimiter after the frame does not arrive: it merges with the next.
    MERGE = "merge"
    #: The frame arrives after the next one.
    DELAY_FRAME = "delay frame"
    #: The frame arrives before the ``value``-th frame after it.
    HOLD_FRAME = "hold frame"
    #: From now on, frames of more than ``value`` bytes do not arrive.
    LOSE_LONG = "lose long frames"
    #: Nothing arrives for ``value`` milliseconds.
    STALL = "stall"
    #: All frames of both directions that end within ``value`` milliseconds are lost.
    GAP = "gap"
    #: From now on, the board's latest frame arrives every ``value`` milliseconds, and no other.
    BABBLE = "babble"
    #: The port is lost permanently.
    CUT = "cut"
    #: The port does not accept bytes for ``value`` milliseconds.
    FULL = "full"
    #: The chip is reset ``value`` cycles after it has received the frame. The model, which answers
    #: immediately, is reset before it receives the frame if ``value`` is even, else before its
    #: answer leaves.
    RESET = "reset"


_DELIMITER = bytes([DELIMITER])
#: Patience with bytes that bring no new answer, as a multiple of the patience with silence.
_FRUITLESS = 8

_OF_FRAMES = (
    LineFault.LOSE_FRAME,
    LineFault.REPEAT_FRAME,
    LineFault.MERGE,
    LineFault.DELAY_FRAME,
    LineFault.HOLD_FRAME,
    LineFault.RESET,
)


@dataclass(frozen=True, order=True)
class LineEvent:
    """A fault at a byte."""

    #: Number of the byte in its direction during the session, from 0.
    at: int
    way: Way
    fault: LineFault
    #: Bit of a flip, 0 to 7; byte of an insertion; number of bytes of noise; milliseconds.
    value: int = 0


@dataclass(frozen=True)
class Frame:
    """Bytes that arrive together."""

    data: bytes
    #: The value of a reset of the chip that receives them.
    reset: int | None = None


class ChipOnLine(Protocol):
    """Chip at the far end of a line."""

    def feed(self, data: bytes, reset: int | None = None) -> bytes:
        """Receive bytes, possibly with a reset in between; return the bytes sent meanwhile."""
        ...

    def wait(self, seconds: float) -> tuple[bytes, float]:
        """Let time pass until a frame has been sent; return its bytes and the seconds."""
        ...

    def memory(self) -> bytes:
        """Return the map and the population, read past the line; empty if nothing can read them."""
        ...

    def paths(self) -> list[list[int]] | None:
        """Return the population of a paper core, read past the line; None if nothing can."""
        ...

    def has_run(self) -> bool:
        """Return whether the planner core has run since its reset; False if nothing can tell."""
        ...


class VirtualClock:
    """A clock that advances with reads from a line, ``now_s`` seconds after its start.

    ``jumps`` are seconds by the number of the reading, as if the process had slept.
    """

    def __init__(self, jumps: Mapping[int, float] | None = None) -> None:
        self.now_s = 0.0
        self._jumps = dict(jumps or {})
        self.readings = 0

    def __call__(self) -> float:
        """Return the time."""
        self.now_s += self._jumps.pop(self.readings, 0.0)
        self.readings += 1
        return self.now_s


class _OneWay:
    """Bytes of one direction, from sending to arrival."""

    def __init__(self, events: Sequence[LineEvent]) -> None:
        self._events = deque(sorted(events))
        self._frame = bytearray()
        self._of_frame: list[LineEvent] = []
        self._late: list[Frame] = []
        # Frames that are held, each with the number of frames that arrive before it.
        self._held: list[tuple[int, Frame]] = []
        self._longest: int | None = None
        self.sent = 0
        self.happened: list[LineEvent] = []

    def quiet(self, size: int) -> int:
        """Return how many of the next ``size`` bytes pass without a fault."""
        return min(self._events[0].at - self.sent, size) if self._events else size

    def send_quietly(self, data: bytes) -> list[Frame]:
        """Send bytes that pass without a fault; return the frames that arrive now."""
        self.sent += len(data)
        *ended, begun = data.split(_DELIMITER)
        arrived = []
        for piece in ended:
            arrived += self._end(piece + _DELIMITER)
        self._frame += begun
        return arrived

    def send(self, value: int) -> tuple[list[Frame], list[LineEvent]]:
        """Send a byte.

        Returns
        -------
        tuple of list
            The frames that arrive now, and the events that do not change bytes.
        """
        arrived = bytearray([value])
        others = []
        while self._events and self._events[0].at <= self.sent:
            event = self._events.popleft()
            self.happened.append(event)
            if event.fault is LineFault.DROP:
                arrived.clear()
            elif event.fault is LineFault.FLIP and arrived:
                arrived[-1] ^= 1 << event.value % 8
            elif event.fault is LineFault.INSERT:
                arrived.insert(0, event.value % 256)
            elif event.fault is LineFault.REPEAT:
                arrived *= 2
            elif event.fault is LineFault.NOISE:
                arrived[:0] = _noise(event)
            elif event.fault is LineFault.LOSE_LONG:
                self._longest = event.value
            elif event.fault in _OF_FRAMES:
                self._of_frame.append(event)
            else:
                others.append(event)
        self.sent += 1
        self._frame += arrived
        if value != DELIMITER:
            return [], others
        return self._end(b""), others

    def _end(self, last: bytes) -> list[Frame]:
        """End a frame with its ``last`` bytes; return the frames that arrive."""
        frame, faults = bytes(self._frame) + last, self._of_frame
        self._frame, self._of_frame = bytearray(), []
        return self._passed(frame, faults)

    def heal(self) -> None:
        """Discard the remaining events."""
        self._events.clear()
        self._longest = None

    def hold(self, data: bytes, frames: int) -> None:
        """Let a frame arrive before the ``frames``-th of the next frames."""
        self._held.append((frames - 1, Frame(data)))

    def forget(self) -> None:
        """Lose the frames that are held, because the chip that holds them is reset."""
        self._held.clear()

    def _passed(self, data: bytes, events: list[LineEvent]) -> list[Frame]:
        late, self._late = self._late, []
        due = [frame for left, frame in self._held if left <= 0]
        self._held = [(left - 1, frame) for left, frame in self._held if left > 0]
        return [*due, *self._arriving(data, events), *late]

    def _arriving(self, data: bytes, events: list[LineEvent]) -> list[Frame]:
        """Return a frame as it arrives now, if it does."""
        faults = {event.fault: event.value for event in events}
        is_long = self._longest is not None and len(data) > self._longest
        if LineFault.LOSE_FRAME in faults or is_long:
            return []
        if LineFault.MERGE in faults:
            data = data[:-1]
        if LineFault.REPEAT_FRAME in faults:
            data *= 2
        frame = Frame(data, faults.get(LineFault.RESET))
        if LineFault.DELAY_FRAME in faults:
            self._late = [frame]
            return []
        if LineFault.HOLD_FRAME in faults:
            self._held.append((faults[LineFault.HOLD_FRAME] - 1, frame))
            return []
        return [frame]


def _noise(event: LineEvent) -> bytes:
    """Return bytes that look random, with few delimiters, and depend only on the event."""
    state = event.at * 2654435761 + event.value
    noise = bytearray()
    for _ in range(event.value):
        state = (state * 6364136223846793005 + 1442695040888963407) % (1 << 64)
        noise.append(state >> 56)
    return bytes(noise)


class FaultyLine:
    """A port whose line has faults; a :class:`pathgene.host.device.transport.Transport`.

    The bytes of a frame arrive together with its delimiter. Reads advance the ``clock`` by the time
    of their bytes or by the timeout; after ``patience_s`` of silence the host must have given up.

    Raises
    ------
    HangError
        From :meth:`read`, after too long a silence, or too long without a new answer.
    OSError
        From all methods, once the port is lost; from :meth:`write` after ``write_timeout``.
    """

    #: Seconds per byte: 3 Mbit/s.
    BYTE_S = 10 / 3e6

    def __init__(
        self,
        chip: ChipOnLine,
        clock: VirtualClock,
        events: Sequence[LineEvent] = (),
        *,
        patience_s: float = 60.0,
    ) -> None:
        self.timeout: float | None = None
        self.write_timeout: float | None = None
        self.closed = False
        self.clock = clock
        self.watch = Watch()
        self._chip, self._patience_s = chip, patience_s
        self._ways = {way: _OneWay([e for e in events if e.way is way]) for way in Way}
        # Frames in flight, each with its time of arrival.
        self._flying: dict[Way, deque[tuple[float, Frame]]] = {way: deque() for way in Way}
        self._stalled_until_s = self._gap_until_s = 0.0
        # Seconds between two repetitions of the latest frame, if there are any, and the next one.
        self._babble_s, self._babbles_at_s = 0.0, math.inf
        self._latest = Frame(b"")
        self._received = bytearray()
        self._silent_s = self._fruitless_s = 0.0
        self._is_cut = False

    @property
    def happened(self) -> list[LineEvent]:
        """The faults that have occurred."""
        return [event for way in self._ways.values() for event in way.happened]

    @property
    def sent(self) -> dict[Way, int]:
        """The number of bytes sent in each direction."""
        return {way: one_way.sent for way, one_way in self._ways.items()}

    @property
    def in_waiting(self) -> int:
        """Bytes that :meth:`read` returns immediately."""
        self._check()
        self._arrive()
        return len(self._received)

    def read(self, size: int = 1, /) -> bytes:
        """Return at most ``size`` bytes; if there are none, let time pass up to the timeout."""
        self._check()
        if self.timeout is None:
            raise HangError("a read without a timeout")
        begun_s, answers = self.clock.now_s, self.watch.answers
        deadline_s = begun_s + self.timeout
        self._arrive()
        while not self._received and self.clock.now_s < deadline_s:
            self._pass_time(deadline_s)
            self._check()
        part = bytes(self._received[:size])
        del self._received[:size]
        self.clock.now_s += self.BYTE_S * len(part)
        self.watch.receive(part, self.clock.now_s)
        self._fruitless_s += self.clock.now_s - begun_s
        if self.watch.answers > answers:
            self._fruitless_s = 0.0
        if self._fruitless_s > _FRUITLESS * self._patience_s:
            raise HangError(f"no end after {self._fruitless_s:.3g} s without a new answer")
        if part:
            self._silent_s = 0.0
        else:
            self._silent_s += self.timeout
            if self._silent_s > self._patience_s:
                raise HangError(f"no end after {self._silent_s:.3g} s of silence")
        return part

    def write(self, data: bytes, /) -> int:
        """Send ``data``."""
        self._check()
        self.watch.send(bytes(data), *self.sent.values())
        self._send(Way.TO_BOARD, bytes(data))
        self._check()
        self._arrive()
        return len(data)

    def hold(self, data: bytes, frames: int) -> None:
        """Let a frame of the board arrive before the ``frames``-th of its next frames."""
        self._ways[Way.FROM_BOARD].hold(data, frames)

    def heal(self) -> None:
        """Discard all remaining faults; a lost port stays lost."""
        for way in self._ways.values():
            way.heal()
        for queue in self._flying.values():
            frames = [(self.clock.now_s, frame) for _, frame in queue]
            queue.clear()
            queue += frames
        self._stalled_until_s = self._gap_until_s = 0.0
        self._silent_s = self._fruitless_s = 0.0
        self._babbles_at_s = math.inf

    def close(self) -> None:
        """Close the port."""
        self.closed = True

    def _check(self) -> None:
        if self._is_cut:
            raise OSError("the device is gone")

    def _send(self, way: Way, data: bytes) -> None:
        one_way = self._ways[way]
        while data and not self._is_cut:
            others: list[LineEvent] = []
            if size := one_way.quiet(len(data)):
                frames = one_way.send_quietly(data[:size])
            else:
                size = 1
                frames, others = one_way.send(data[0])
            data = data[size:]
            self._happen(way, others)
            if self.clock.now_s < self._gap_until_s:
                continue
            # In order, even after frames that a stall holds back.
            at_s = max(self._stalled_until_s, self.clock.now_s)
            self._flying[way] += ((at_s, frame) for frame in frames)

    def _happen(self, way: Way, events: list[LineEvent]) -> None:
        """Apply events that do not change bytes."""
        for event in events:
            if event.fault is LineFault.CUT:
                self._is_cut = True
            elif event.fault is LineFault.STALL:
                self._stalled_until_s = max(
                    self._stalled_until_s, self.clock.now_s + event.value / 1000
                )
            elif event.fault is LineFault.GAP:
                self._gap_until_s = max(self._gap_until_s, self.clock.now_s + event.value / 1000)
            elif event.fault is LineFault.BABBLE:
                self._babble_s = event.value / 1000
                self._babbles_at_s = self.clock.now_s + self._babble_s
            elif event.fault is LineFault.FULL and way is Way.TO_BOARD:
                self._fill(event.value / 1000)

    def _fill(self, seconds: float) -> None:
        """Accept no bytes for some seconds."""
        limit_s = self.write_timeout
        self.clock.now_s += seconds if limit_s is None else min(seconds, limit_s)
        if limit_s is None and seconds > self._patience_s:
            raise HangError("a write without a timeout")
        if limit_s is not None and seconds > limit_s:
            raise TimeoutError("the port took no bytes")

    def _arrive(self) -> None:
        """Let everything arrive whose time has come."""
        to_board, from_board = self._flying[Way.TO_BOARD], self._flying[Way.FROM_BOARD]
        while to_board and to_board[0][0] <= self.clock.now_s:
            frame = to_board.popleft()[1]
            if frame.reset is not None:
                self._ways[Way.FROM_BOARD].forget()
            self._send(Way.FROM_BOARD, self._chip.feed(frame.data, frame.reset))
        # One frame at a time, as bytes come from a line one after another.
        if self._babbles_at_s < math.inf:
            from_board.clear()
            if not self._received and self._babbles_at_s <= self.clock.now_s:
                self._babbles_at_s = self.clock.now_s + self._babble_s
                self._received += self._latest.data
        while not self._received and from_board and from_board[0][0] <= self.clock.now_s:
            self._latest = from_board.popleft()[1]
            self._received += self._latest.data

    def _pass_time(self, deadline_s: float) -> None:
        """Let time pass until something arrives, at most until the deadline."""
        due_s = (queue[0][0] for queue in self._flying.values() if queue)
        next_s = min((*due_s, self._babbles_at_s, deadline_s))
        until_s = min(max(next_s, self.clock.now_s), deadline_s)
        sent, seconds = self._chip.wait(until_s - self.clock.now_s)
        self.clock.now_s = self.clock.now_s + seconds if sent else until_s
        self._send(Way.FROM_BOARD, sent)
        self._arrive()
