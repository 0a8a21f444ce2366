"""The end of a mission that a user asks for: a circle, a landing or a return to home."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.formats.flight_plan import EndKind
from pathgene.host.numeric import numbers
from pathgene.host.problem.ends import finite, place
from pathgene.host.problem.problem import Problem


__all__ = ["LOITER", "Ending", "ending_of", "summary_ending", "with_end"]


@dataclass(frozen=True)
class Ending:
    """The end of a mission after its goal.

    Parameters
    ----------
    kind : str
        ``loiter``, ``land`` or ``rtl``.
    land : (float, float, float) or None
        Place of a landing, x and y in metres of the terrain's frame, and the heading there, degrees
        clockwise from true north.
    """

    kind: EndKind
    land: tuple[float, float, float] | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the end as a summary states it."""
        return {"kind": self.kind, "land": None if self.land is None else list(self.land)}


#: The default.
LOITER = Ending("loiter")


def ending_of(values: Mapping[str, Any], problem: Problem) -> Ending | None:
    """Return the end that the values of a problem file or parsed arguments name; None for none.

    Raises
    ------
    InputError
        If the values contradict each other, a number is bad, or the landing is off the map or in a
        no-fly zone.
    """
    terrain = problem.terrain
    kind, local, geographic = (values.get(name) for name in ("end", "land", "land_geo"))
    given = geographic if local is None else local
    if given is None:
        if kind == "land":
            raise InputError(
                "The end land needs the place and the heading of the landing; give --land."
            )
        return None if kind is None else Ending(kind)
    if kind not in (None, "land"):
        raise InputError(
            f"A mission that lands does not end with {kind}; leave out --end or --land."
        )
    x, y, heading_deg = finite("landing", given, 3)
    if not abs(heading_deg) <= 360:
        raise InputError(
            "The heading of the landing must be from -360 to 360 degrees from north, not "
            f"{heading_deg:g}."
        )
    if local is None:
        x, y = place("landing", x, y, terrain)
    if not (0 <= x <= terrain.width_m and 0 <= y <= terrain.height_m):
        raise InputError(
            f"The landing at ({x:g}, {y:g}) is outside the map, which reaches to "
            f"({terrain.width_m:g}, {terrain.height_m:g}); give another place (--land)."
        )
    if zone := problem.zone_at((x, y, terrain.ground(x, y))):
        raise InputError(
            f"The landing at ({x:.10g}, {y:.10g}) is inside {zone}; give another place (--land)."
        )
    return Ending("land", (x, y, heading_deg % 360.0))


def with_end(summary: Mapping[str, Any], ending: Ending | None) -> dict[str, Any]:
    """Return a summary that also states the end of its mission, if one is named."""
    return dict(summary) if ending is None else {**summary, "end": ending.to_dict()}


def summary_ending(file: Path, summary: Mapping[str, Any]) -> Ending:
    """Return the end that the summary of a plan states; by default a circle.

    Raises
    ------
    InputError
        If it is bad.
    """
    stated = summary.get("end")
    if stated is None:
        return LOITER
    try:
        kind, land = stated["kind"], stated["land"]
        if kind not in ("loiter", "land", "rtl") or (kind == "land") == (land is None):
            raise ValueError
        if land is None:
            return Ending(kind)
        x, y, heading_deg = numbers(land, 3)
        return Ending(kind, (x, y, math.fmod(heading_deg, 360.0)))
    except (KeyError, TypeError, ValueError):
        raise InputError(
            f"{file}: end must be a table with the kind loiter, land or rtl, and three numbers "
            f"under land for a landing, not {stated!r}."
        ) from None
