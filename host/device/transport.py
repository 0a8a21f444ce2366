"""The port that a link needs, a subset of :class:`serial.Serial`, and the counts of its traffic."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


__all__ = ["Traffic", "Transport"]


class Transport(Protocol):
    """A port of bytes with pyserial's interface: a real port, a simulated board or a model.

    Its methods raise :class:`OSError`, as pyserial's do, or :class:`pathgene.host.errors.JobError`.

    Attributes
    ----------
    timeout, write_timeout : float or None
        Longest waits of :meth:`read` and :meth:`write`, seconds.
    """

    timeout: float | None
    write_timeout: float | None

    @property
    def in_waiting(self) -> int:
        """Bytes that :meth:`read` would return immediately."""
        ...

    def read(self, size: int = 1, /) -> bytes:
        """Return ``size`` bytes, or fewer if the timeout comes first."""
        ...

    def write(self, data: bytes, /) -> int | None:
        """Send all of ``data``, or raise TimeoutError if ``write_timeout`` comes first."""
        ...

    def close(self) -> None:
        """Close the connection."""
        ...


@dataclass
class Traffic:
    """Traffic of a link since it was made.

    Attributes
    ----------
    bytes_to_board, bytes_from_board : int
        Bytes, delimiters and damaged bytes included.
    frames_to_board, frames_from_board : int
        Frames sent, repeated frames included, and good frames received.
    frames_repeated : int
        Frames repeated because their answer was missing.
    exchanges : int
        Number of times that the host waited for answers, to one command or to several sent
        together.
    waiting_s : float
        Seconds spent waiting for bytes from the board, and for the port to take bytes.
    """

    bytes_to_board: int = 0
    bytes_from_board: int = 0
    frames_to_board: int = 0
    frames_from_board: int = 0
    frames_damaged: int = 0
    frames_repeated: int = 0
    exchanges: int = 0
    waiting_s: float = 0.0

    def since(self, before: Traffic) -> Traffic:
        """Return the traffic since an earlier state, of which ``before`` is a copy."""
        earlier = vars(before)
        return Traffic(**{name: value - earlier[name] for name, value in vars(self).items()})
