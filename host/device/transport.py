"""What the link needs of a port: a part of :class:`serial.Serial`."""

from __future__ import annotations

from typing import Protocol


__all__ = ["Transport"]


class Transport(Protocol):
    """A port of bytes, as pyserial has them.

    Real ports, simulated boards and models alike; errors are :class:`OSError`, which pyserial's are
    too, or :class:`host.errors.JobError`.

    Attributes
    ----------
    timeout : float or None
        Longest wait of a :meth:`read`, seconds.
    """

    timeout: float | None

    @property
    def in_waiting(self) -> int:
        """Bytes that :meth:`read` would return at once."""
        ...

    def read(self, size: int = 1, /) -> bytes:
        """Return ``size`` bytes, or fewer if the timeout comes first."""
        ...

    def write(self, data: bytes, /) -> int | None:
        """Send all of ``data``."""
        ...

    def close(self) -> None:
        """Hang up."""
        ...
