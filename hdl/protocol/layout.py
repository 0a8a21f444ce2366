"""Bit fields of a payload."""

from __future__ import annotations

import re
from dataclasses import dataclass

from pathgene.hdl.config import Config


__all__ = ["Field", "Layout", "numbered", "sized"]


class Field(tuple[str, int]):
    """Name and width of a field, with its text for the protocol page.

    Parameters
    ----------
    width : int
        Bits.
    values : str
        Range of values.
    size : str or None
        Attribute of :class:`pathgene.hdl.config.Config` that gives the width; None if the width is
        constant.
    """

    values: str
    meaning: str
    size: str | None

    def __new__(
        cls,
        name: str,
        width: int,
        values: str,
        meaning: str,
        size: str | None = None,
    ) -> Field:
        """Make a field, which equals the pair of its name and width."""
        field = super().__new__(cls, (name, width))
        field.values, field.meaning, field.size = values, meaning, size
        return field

    @property
    def base(self) -> str:
        """Name without the number of a numbered field."""
        return re.sub(r"_\d+$", "", self[0])


def sized(config: Config, name: str, size: str, values: str, meaning: str) -> Field:
    """Return a field whose width is the attribute ``size`` of ``config``."""
    return Field(name, getattr(config, size), values, meaning, size)


@dataclass(frozen=True)
class Layout:
    """Bit fields of a payload without gaps, first field lowest.

    Parameters
    ----------
    fields : tuple of (str, int)
        Name and width in bits of each field, lowest first, as :class:`Field` objects or as pairs
        without a text.
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
        """Return the payload of ``values``, one value for each field.

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


def numbered(
    name: str, count: int, width: int, values: str, meaning: str, size: str | None = None
) -> tuple[Field, ...]:
    """Return ``count`` fields of the same width and text, named ``name_0`` and so on."""
    return tuple(Field(f"{name}_{i}", width, values, meaning, size) for i in range(count))
