"""Points and polygons of files: an intermediate form of zones between a file and a problem."""

from __future__ import annotations

from typing import Any, NamedTuple


__all__ = ["Ring", "Shape", "wound"]

#: Corners x, y in metres of a terrain's local frame; the closing corner is left out.
Ring = tuple[tuple[float, float], ...]


class Shape(NamedTuple):
    """A point (one ring of one position) or a polygon (its ring and its holes), with properties.

    The properties of a zone are ``name``, ``lower`` and ``upper`` (metres), ``t0`` and ``t1``
    (seconds); only the values that are set appear. A point with the property ``radius_m`` is a
    circle.
    """

    kind: str
    rings: tuple[Ring, ...]
    properties: dict[str, Any]


def wound(ring: Ring, *, left: bool) -> Ring:
    """Return the ring counter-clockwise if ``left``, otherwise clockwise."""
    pairs = zip(ring, (*ring[1:], ring[0]), strict=True)
    area = sum(xa * yb - xb * ya for (xa, ya), (xb, yb) in pairs)
    return ring if (area >= 0) == left else ring[::-1]
