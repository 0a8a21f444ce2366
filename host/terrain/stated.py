"""A user's statements on the heights of a terrain whose file is silent or wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.numeric import real


__all__ = ["HEIGHTS", "HEIGHT_UNITS", "NO_WATER", "Stated"]

#: Units of heights, and their metres.
HEIGHT_UNITS = {"m": 1.0, "ft": 0.3048, "us-ft": 1200 / 3937}
#: References from which heights are measured.
HEIGHTS = ("sea-level", "ellipsoidal")
#: The word for land below the sea.
NO_WATER = "none"


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

    Raises
    ------
    InputError
        If a value is none of these.
    """

    height_unit: str | None = None
    heights: str | None = None
    water_level: float | str | None = None

    def __post_init__(self) -> None:
        for name, value, known in (
            ("unit of heights", self.height_unit, tuple(HEIGHT_UNITS)),
            ("reference of heights", self.heights, HEIGHTS),
        ):
            if value is not None and value not in known:
                raise InputError(f"The {name} must be {' or '.join(known)}, not {value!r}.")
        level = self.water_level
        if level is None or level == NO_WATER:
            return
        if isinstance(level, str) or not math.isfinite(real("water level", level)):
            raise InputError(
                f"The water level must be a height in metres or {NO_WATER}, not {level!r}."
            )

    def to_dict(self) -> dict[str, Any]:
        """The stated values, as in a summary."""
        return {name: value for name, value in vars(self).items() if value is not None}
