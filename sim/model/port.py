"""Serial port with the software model at its other end."""

from __future__ import annotations

from pathgene.sim.model.chip import Chip


__all__ = ["ModelPort"]


class ModelPort:
    """The methods of :class:`serial.Serial` that a link uses, over a :class:`Chip`.

    The model answers during a write, so a read never waits: bytes that are not there yet come only
    after another write.

    Parameters
    ----------
    chip : Chip
    """

    def __init__(self, chip: Chip) -> None:
        self.chip = chip
        self.timeout: float | None = None
        self.write_timeout: float | None = None  # A write never waits.
        self._received = bytearray()

    @property
    def in_waiting(self) -> int:
        """Bytes that :meth:`read` would return."""
        return len(self._received)

    def read(self, size: int = 1) -> bytes:
        """Return at most ``size`` of the bytes that the chip has sent."""
        part = bytes(self._received[:size])
        del self._received[:size]
        return part

    def write(self, data: bytes | bytearray | memoryview) -> int:
        """Pass ``data`` to the chip and return its length."""
        self._received += self.chip.feed(bytes(data))
        return len(data)

    def flush(self) -> None:
        """Do nothing: all written bytes have arrived."""

    def close(self) -> None:
        """End the work of the model."""
        self.chip.close()
