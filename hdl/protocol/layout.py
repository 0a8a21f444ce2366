"""Bit fields of a payload."""

from __future__ import annotations

from dataclasses import dataclass


__all__ = ["Layout", "numbered"]


@dataclass(frozen=True)
class Layout:
    """Bit fields of a payload, without gaps and the first field lowest.

    Parameters
    ----------
    fields : tuple of (str, int)
        Name and width in bits of each field, the lowest first.
    """

    fields: tuple[tuple[str, int], ...]

    @property
    def bits(self) -> int:
        """Total width of the fields."""
        return sum(width for _, width in self.fields)

    @property
    def size(self) -> int:
        """Bytes on the link."""
        return (self.bits + 7) // 8

    def pack(self, **values: int) -> bytes:
        """Return the payload with ``values``, one value for each field.

        Raises
        ------
        ValueError
            If a field is missing, unknown, or does not fit.
        """
        names = [name for name, _ in self.fields]
        if sorted(values) != sorted(names):
            raise ValueError(f"Fields must be {names}, not {list(values)}")
        packed = shift = 0
        for name, width in self.fields:
            if not 0 <= values[name] < 1 << width:
                raise ValueError(f"{name} must fit in {width} bits, not {values[name]!r}")
            packed |= values[name] << shift
            shift += width
        return packed.to_bytes(self.size, "little")

    def unpack(self, payload: bytes) -> dict[str, int]:
        """Return the fields of ``payload``.

        Raises
        ------
        ValueError
            If its size is not :attr:`size`.
        """
        if len(payload) != self.size:
            raise ValueError(f"Payload must have {self.size} bytes, not {len(payload)}")
        packed = int.from_bytes(payload, "little")
        values = {}
        for name, width in self.fields:
            values[name] = packed & ((1 << width) - 1)
            packed >>= width
        return values


def numbered(name: str, count: int, width: int) -> tuple[tuple[str, int], ...]:
    """Return ``count`` fields of the same width, named ``name_0`` and so on."""
    return tuple((f"{name}_{i}", width) for i in range(count))
