"""A user's statements on the heights of a terrain whose file is silent or wrong."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from numbers import Real
from typing import Any, Self

from pathgene.host.errors import InputError
from pathgene.host.numeric import real


__all__ = ["EVERY_HEIGHT", "HEIGHTS", "HEIGHT_UNITS", "NO_WATER", "STATEMENTS", "Stated"]

#: Units of heights, and their metres.
HEIGHT_UNITS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "ft": 0.3048, "us-ft": 1200 / 3937}
#: References from which heights are measured.
HEIGHTS = ("sea-level", "ellipsoidal")
#: The word for land below the sea.
NO_WATER = "none"
#: The word for files in which no number marks a void.
EVERY_HEIGHT = "none"


@dataclass(frozen=True)
class Stated:
    """A user's statements on heights; None leaves the value to the file.

    Parameters
    ----------
    height_unit : str, optional
        A key of :data:`HEIGHT_UNITS`.
    heights : str, optional
        One of :data:`HEIGHTS`.
    water_level : float or str, optional
        Height of the water above the datum in metres, or ``none``.
    void : float, sequence of float or str, optional
        Numbers of the file that mark voids, kept as a tuple; or ``none``, which takes all numbers
        from -11,000 to 9,000 m as heights.

    Raises
    ------
    InputError
        If a value is none of these.
    """

    height_unit: str | None = None
    heights: str | None = None
    water_level: float | str | None = None
    void: float | Sequence[float] | str | None = None

    def __post_init__(self) -> None:
        for name, value, known in (
            ("unit of heights", self.height_unit, tuple(HEIGHT_UNITS)),
            ("reference of heights", self.heights, HEIGHTS),
        ):
            if value is not None and value not in known:
                raise InputError(f"The {name} must be {' or '.join(known)}, not {value!r}.")
        object.__setattr__(self, "void", _void(self.void))
        level = self.water_level
        if level is None or level == NO_WATER:
            return
        if isinstance(level, str) or not math.isfinite(real("water level", level)):
            raise InputError(
                f"The water level must be a height in metres or {NO_WATER}, not {level!r}."
            )

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Return the statements among the values of a problem or of a summary."""
        return cls(**{name: values.get(name) for name in STATEMENTS})

    @property
    def marks(self) -> tuple[float, ...]:
        """The numbers that mark voids."""
        return self.void if isinstance(self.void, tuple) else ()

    @property
    def accepts_all(self) -> bool:
        """True if no number marks a void."""
        return isinstance(self.void, str)

    def to_dict(self) -> dict[str, Any]:
        """The stated values, as in a summary."""
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in vars(self).items()
            if value is not None
        }


def _void(value: Any) -> tuple[float, ...] | str | None:
    """Return the marks of voids that are stated as one number, several, or in a word."""
    if value is None:
        return None
    if isinstance(value, str) and value == EVERY_HEIGHT:
        return EVERY_HEIGHT
    numbers = [value] if isinstance(value, Real) else value
    if not isinstance(numbers, str | bytes):
        with contextlib.suppress(TypeError, InputError):
            marks = tuple(real("mark of a void", number) for number in numbers)
            if marks and all(map(math.isfinite, marks)):
                return marks
    raise InputError(
        f"The marks of voids must be numbers of the file or {EVERY_HEIGHT}, not {value!r}."
    )


#: Names of the statements, in problems and in summaries.
STATEMENTS = tuple(each.name for each in fields(Stated))
