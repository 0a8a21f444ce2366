"""The reason why a problem has no path, as people and programs read it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import PathgeneError
from pathgene.host.terrain import Terrain


__all__ = [
    "CODES",
    "Figure",
    "Reason",
    "broken_limit",
    "geographic",
    "is_unknown",
    "listed",
    "rounded_down",
    "rounded_up",
]

#: Every code, in the order in which reasons are checked.
CODES = (
    "start",
    "goal",
    "closed",
    "ceiling",
    "climb",
    "descent",
    "power",
    "fuel",
    "turn",
    "heading",
    "joint",
    "not-found",
)


# Digits of the figures of a broken limit; more only if the figures would look equal.
_DIGITS = range(3, 12)
# Names in a sentence.
_MOST_NAMES = 5
# A smaller share of a step is a rounding error.
_ROUNDING = 1e-6


@dataclass(frozen=True)
class Figure:
    """A limit that forbids every path, and a value that would allow one.

    Parameters
    ----------
    limit : str
        Name of the limit, as in the ``limits`` of a summary.
    allowed : float
        The present limit.
    would_do : float or None
        A value that would allow a path, or the minimum that is needed; None if no value would.
    """

    limit: str
    allowed: float
    would_do: float | None
    unit: str

    def to_dict(self) -> dict[str, Any]:
        """The figure in plain JSON values."""
        return {
            "limit": self.limit,
            "allowed": self.allowed,
            "would_do": self.would_do,
            "unit": self.unit,
        }


@dataclass(frozen=True, eq=False, kw_only=True)
class Reason:
    """The reason why there is no path.

    Parameters
    ----------
    code : str
        One of :data:`CODES`.
    sentence : str
        The reason for people, with names, places and figures.
    proven : bool
        True if no path exists at all; False if the search finds none at its cell size, or without
        circling.
    zones : tuple of str
        Names of the zones that forbid every path.
    place : (float, float) or None
        The place, metres in the local frame.
    place_geo : (float, float) or None
        The place as WGS84 latitude and longitude, for a terrain with a reference system.
    figure : Figure or None
        The limit, and a value that would allow a path.
    end : str or None
        The end that violates a limit or is enclosed, ``start`` or ``goal``.
    ring : tuple of (n, 2) float64
        The ring around that end, in lines of metres; empty if there is none.
    region : (ny, nx) bool or None
        Nodes that can be reached from that end.
    headings : tuple of (str, float, float)
        Ends whose heading is the reason, each with the fixed heading and the heading of a path
        that is free to choose it, degrees.
    """

    code: str
    sentence: str
    proven: bool
    zones: tuple[str, ...] = ()
    place: tuple[float, float] | None = None
    place_geo: tuple[float, float] | None = None
    figure: Figure | None = None
    end: str | None = None
    ring: tuple[NDArray[np.float64], ...] = ()
    region: NDArray[np.bool_] | None = None
    headings: tuple[tuple[str, float, float], ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """The reason in plain JSON values, without the region and the headings."""
        return {
            "code": self.code,
            "sentence": self.sentence,
            "proven": self.proven,
            "zones": list(self.zones),
            "place": None if self.place is None else list(self.place),
            "place_geo": None if self.place_geo is None else list(self.place_geo),
            "figure": None if self.figure is None else self.figure.to_dict(),
            "end": self.end,
            "ring": [line.tolist() for line in self.ring],
        }


def geographic(terrain: Terrain, place: tuple[float, float]) -> tuple[float, float] | None:
    """Return latitude and longitude of a place; None if the terrain has no place on Earth."""
    if terrain.crs is None:
        return None
    try:
        latitude, longitude = terrain.to_geographic(*place)
    except PathgeneError:
        return None
    return float(latitude), float(longitude)


def rounded_up(value: float, step: float = 0.1) -> float:
    """Return the next multiple of ``step``: the smallest printable figure that is enough."""
    return round(math.ceil(value / step - _ROUNDING) * step, 12)


def rounded_down(value: float, step: float = 0.1) -> float:
    """Return the previous multiple of ``step``: the largest figure to print within the limit."""
    return round(math.floor(value / step + _ROUNDING) * step, 12)


def broken_limit(limits: Sequence[Mapping[str, Any]] | None) -> str | None:
    """Return the end of a sentence on the limit that a path breaks most; None if it breaks none.

    Parameters
    ----------
    limits : sequence of mapping or None
        The ``limits`` of a summary, worst first; None with ``as_paper``.
    """
    if not limits:
        return None
    name, worst, allowed = str(limits[0]["limit"]), limits[0]["worst"], limits[0]["allowed"]
    place = f"{limits[0]['at_m']:.0f} m from the start"
    if is_unknown(worst):
        return f"breaks the limit {name} over a void, {place}"
    if name == "map":
        return f"has a corridor that leaves the map by {-worst:.3g} m, {place}"
    # Loads the kernels, which a reason alone does not need.
    from pathgene.host.evaluation.aircraft_limits import limit_named

    limit = limit_named(name)
    least = limit.is_minimum if limit else name == "clearance" or name.startswith("zone ")
    if not (worst < allowed if least else worst > allowed):
        return None
    texts = ((f"{worst:.{digits}g}", f"{allowed:.{digits}g}") for digits in _DIGITS)
    reached, bound = next((pair for pair in texts if pair[0] != pair[1]), (worst, allowed))
    return f"breaks the limit {name}, {reached} where {bound} is allowed, {place}"


def is_unknown(worst: float | None) -> bool:
    """Return whether the worst value of a limit is a clearance over a void.

    It is minus infinity in an evaluation, and None in a summary.
    """
    return worst is None or worst == -math.inf


def listed(names: Iterable[str]) -> str:
    """Return names joined by commas and ``and``; a long list ends in the number of the rest."""
    all_names = list(names)
    if len(all_names) > _MOST_NAMES:
        rest = len(all_names) - _MOST_NAMES + 1
        all_names = [*all_names[: _MOST_NAMES - 1], f"{rest} more"]
    *most, last = all_names
    return f"{', '.join(most)} and {last}" if most else last
