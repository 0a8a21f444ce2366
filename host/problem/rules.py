"""Rules of safe flight that a path must keep in addition to the evaluation of the papers."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.numeric import real


__all__ = ["Rules"]

#: Names of the rules in messages to users.
_NAMES = {
    "clearance_m": "clearance",
    "corridor_m": "corridor",
    "ceiling_m": "ceiling",
    "ceiling_agl_m": "ceiling above ground",
    "zone_margin_m": "zone margin",
    "reserve": "fuel reserve",
}


@dataclass(frozen=True, kw_only=True)
class Rules:
    """Distances that a path keeps from terrain, zones and ceilings, and the fuel reserve.

    Parameters
    ----------
    clearance_m : float
        Minimum height over the surface, 0 or more. Less is required near start and goal: see
        :func:`pathgene.host.problem.surface.required_m`.
    corridor_m : float
        Distance to either side of the track within which the clearance is kept, 0 or more.
    ceiling_m : float, optional
        Maximum altitude above the terrain's datum.
    ceiling_agl_m : float, optional
        Maximum height over the surface, above 0.
    zone_margin_m : float
        Distance kept from no-fly zones on every side, 0 or more.
    reserve : float
        Share of the fuel that must be left at the goal, from 0 to below 1.

    Raises
    ------
    InputError
        If a value is not a finite number or outside its range.
    """

    clearance_m: float = 30.0
    corridor_m: float = 25.0
    ceiling_m: float | None = None
    ceiling_agl_m: float | None = None
    zone_margin_m: float = 25.0
    reserve: float = 0.10

    def __post_init__(self) -> None:
        for rule, name in _NAMES.items():
            value = getattr(self, rule)
            if value is None and rule.startswith("ceiling"):
                continue
            number = real(name, value)
            if not math.isfinite(number):
                raise InputError(f"The {name} must be a finite number, not {number:g}.")
            object.__setattr__(self, rule, number)
        for rule in ("clearance_m", "corridor_m", "zone_margin_m"):
            if getattr(self, rule) < 0:
                raise InputError(
                    f"The {_NAMES[rule]} must be 0 m or more, not {getattr(self, rule):g} m."
                )
        if self.ceiling_agl_m is not None and not self.ceiling_agl_m > self.clearance_m:
            raise InputError(
                f"The ceiling above ground must be above the clearance of {self.clearance_m:g} m, "
                f"not {self.ceiling_agl_m:g} m."
            )
        if not 0 <= self.reserve < 1:
            raise InputError(
                f"The fuel reserve must be from 0 to below 100 %, not {100 * self.reserve:g} %."
            )

    def to_dict(self) -> dict[str, Any]:
        """The rules as in ``summary.json``; None for a ceiling that is not set."""
        return {field.name: getattr(self, field.name) for field in fields(self)}
