"""ED-269 of EUROCAE, the JSON in which states publish zones for UAS.

The project has its own reader because the types of the library `uas-standards` require authorities
and contacts, which many publications omit.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.formats import classes
from pathgene.host.formats.areas import Placing, Rings
from pathgene.host.formats.collection import (
    Member,
    check_order,
    members,
    read_members,
    sized,
)
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import Feature, LeftOut, Limit, Read
from pathgene.host.formats.limits import limit
from pathgene.host.formats.times import applicability, doubts_on_times


__all__ = ["features", "recognises"]

RESTRICTIONS = ("PROHIBITED", "REQ_AUTHORISATION", "CONDITIONAL", "NO_RESTRICTION")


def recognises(content: Content) -> bool:
    """Return whether a member has a volume with a horizontal projection."""
    return any(
        isinstance(volume, dict) and "horizontalProjection" in volume
        for member in members(content.json)
        if isinstance(member, dict)
        for volume in _volumes(member.get("geometry"))
    )


def features(content: Content) -> Iterator[Read]:
    """Yield the volumes of the zones."""
    return read_members(content.json, _zone)


def _volumes(geometry: Any) -> list[Any]:
    return geometry if isinstance(geometry, list) else [geometry]


def _zone(member: Member) -> Iterator[Read]:
    if not member.geometry:
        yield LeftOut(member.label, "it has no geometry")
        return
    category = classes.of_word(str(member.properties.get("restriction", "")))
    if category not in RESTRICTIONS:
        raise InputError(
            f"its restriction must be one of {', '.join(RESTRICTIONS)}, not "
            f"{member.properties.get('restriction')!r}."
        )
    stated = member.properties.get("applicability")
    periods, remarks = applicability(stated), doubts_on_times(stated)
    for volume in _volumes(member.geometry):
        if not isinstance(volume, dict):
            raise InputError(f"a volume must be an object, not {volume!r}.")
        lower, upper = _limit(volume, "lower"), _limit(volume, "upper")
        check_order(lower, upper)
        for rings, radius_m in _projections(volume.get("horizontalProjection")):
            yield Feature(
                member.number,
                member.name,
                rings,
                radius_m,
                lower,
                upper,
                periods,
                category,
                forbids=classes.forbids(category),
                remarks=remarks,
            )


def _limit(volume: Mapping[str, Any], side: str) -> Limit | None:
    value = volume.get(f"{side}Limit")
    if value is None:
        return None
    return limit(value, volume.get("uomDimensions", "M"), volume.get(f"{side}VerticalReference"))


def _projections(projection: Any) -> Iterator[tuple[Rings, float | None]]:
    """Yield rings and radius of each part; a radius is in metres, whatever the unit of heights.

    Some publications give the radius in the unit of heights; reading it as metres then gives the
    larger circle.
    """
    if not isinstance(projection, dict):
        raise InputError('a volume must have a "horizontalProjection".')
    kind = str(projection.get("type")).lower()
    if kind == "circle":
        yield (Placing().ring([projection.get("center")]),), sized(projection.get("radius"))
        return
    if kind not in ("polygon", "multipolygon"):
        raise InputError(
            f"a horizontalProjection must be a Circle or a Polygon, not {projection.get('type')!r}."
        )
    coordinates = projection.get("coordinates")
    polygons = coordinates if kind == "multipolygon" else [coordinates]
    for rings in polygons if isinstance(polygons, list) else [None]:
        if not isinstance(rings, list) or not rings:
            raise InputError("a Polygon must have at least one ring.")
        yield tuple(map(corners_of, rings)), None


def corners_of(ring: Any) -> tuple[tuple[float, float], ...]:
    """Return the corners of a ring, three or more.

    Raises
    ------
    InputError
        If it has fewer, or a position is bad.
    """
    corners = Placing().ring(ring)
    if len(set(corners)) < 3:
        raise InputError("a ring must have three corners or more.")
    return corners
