"""The port that a link needs: a subset of :class:`serial.Serial`."""

from __future__ import annotations

from typing import Protocol


__all__ = ["Transport"]


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
        """Bytes that :meth:`read` would return at once."""
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
