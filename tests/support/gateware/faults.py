"""A line with seeded faults to a chip that is a function of bytes.

Time is virtual: a read advances a clock, so timeouts cost no real time, and the same seed gives the
same run.
"""

import random
from collections.abc import Callable

from pathgene.hdl.protocol.codec import DELIMITER
from tools.faults.line import VirtualClock


class ByteFaults:
    """Faults of single bytes.

    Parameters
    ----------
    rate : float
        Probability per byte of each of five faults: a flipped bit, a repeated byte, a lost byte, a
        random byte before it, and a second chance of loss for delimiters.

    Attributes
    ----------
    count : int
        Number of faults that have occurred.
    """

    def __init__(self, rate: float, rng: random.Random) -> None:
        self.rate = rate
        self.count = 0
        self._rng = rng

    def __call__(self, data: bytes) -> bytes:
        """Return the bytes that arrive when ``data`` is sent."""
        rng, rate = self._rng, self.rate
        arrived = bytearray()
        for value in data:
            parts = bytearray([value])
            if rng.random() < rate:
                parts[0] ^= 1 << rng.randrange(8)
                self.count += 1
            if rng.random() < rate:
                parts *= 2
                self.count += 1
            if rng.random() < rate or (value == DELIMITER and rng.random() < rate):
                parts.clear()
                self.count += 1
            if rng.random() < rate:
                parts.insert(0, rng.randrange(256))
                self.count += 1
            arrived += parts
        return bytes(arrived)


class FrameFaults:
    """Faults of whole frames: lost, repeated, merged with the next, or swapped with the next.

    Parameters
    ----------
    rate : float
        Probability per frame of each fault.

    Attributes
    ----------
    count : int
        Number of faults that have occurred.
    """

    def __init__(self, rate: float, rng: random.Random) -> None:
        self.rate = rate
        self.count = 0
        self._rng = rng
        self._begun = b""
        self._late = b""

    def __call__(self, data: bytes) -> bytes:
        """Return the bytes that arrive; a frame arrives with its delimiter."""
        *frames, self._begun = (self._begun + data).split(bytes([DELIMITER]))
        return b"".join(self._pass(frame + bytes([DELIMITER])) for frame in frames)

    def _pass(self, frame: bytes) -> bytes:
        faults: tuple[Callable[[bytes], bytes], ...] = (
            lambda frame: b"",
            lambda frame: frame * 2,
            lambda frame: frame[:-1],
            self._delay,
        )
        drawn = int(self._rng.random() / self.rate) if self.rate else len(faults)
        late, self._late = self._late, b""
        if drawn < len(faults):
            self.count += 1
            frame = faults[drawn](frame)
        return frame + late

    def _delay(self, frame: bytes) -> bytes:
        self._late = frame
        return b""


class FaultyTransport:
    """A port whose line has faults in both directions.

    Parameters
    ----------
    chip : Callable[[bytes], bytes]
        Returns the chip's reply to the bytes that arrive.
    clock : VirtualClock
        Advanced by every read, by the time of its bytes or by the timeout.
    to_board, from_board : Callable[[bytes], bytes]
        Faults: they return the bytes that arrive when their argument is sent.
    """

    #: Seconds per byte: 3 Mbit/s.
    BYTE_S = 10 / 3e6

    def __init__(
        self,
        chip: Callable[[bytes], bytes],
        clock: VirtualClock,
        *,
        to_board: Callable[[bytes], bytes] = bytes,
        from_board: Callable[[bytes], bytes] = bytes,
    ) -> None:
        self.timeout: float | None = None
        self.write_timeout: float | None = None
        self.closed = False
        self._chip = chip
        self._clock = clock
        self._to_board = to_board
        self._from_board = from_board
        self._received = bytearray()

    @property
    def in_waiting(self) -> int:
        """Bytes that :meth:`read` returns immediately."""
        return len(self._received)

    def read(self, size: int = 1) -> bytes:
        """Return at most ``size`` bytes; if there are none, let the timeout pass."""
        part = bytes(self._received[:size])
        del self._received[:size]
        if part:
            self._clock.now_s += self.BYTE_S * len(part)
        else:
            assert self.timeout is not None, "a read without a timeout would never end"
            self._clock.now_s += self.timeout
        return part

    def write(self, data: bytes) -> int:
        """Send ``data``; the chip replies immediately."""
        arrived = self._to_board(bytes(data))
        # Bytes arrive in pieces.
        for at in range(0, len(arrived), 61):
            self._received += self._from_board(self._chip(arrived[at : at + 61]))
        return len(data)

    def close(self) -> None:
        """Hang up."""
        self.closed = True
