"""Doubts about the shapes of zones: outlines, ways around the Earth, degrees taken as metres."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence

from pathgene.host.formats.features import Feature
from pathgene.host.problem.placing import (
    Placed,
    goes_short_way,
    in_degrees_on_map,
    long_way_on_map,
)
from pathgene.host.remarks import Grade, Remark
from pathgene.host.terrain import Terrain


__all__ = ["in_degrees", "labelled", "tangled", "turned"]

# Names in one sentence.
_NAMES = 5
# Extent in metres below which nobody draws a zone, and the largest longitude and latitude.
_SMALL_M, _DEGREES = 5.0, (180.0, 90.0)


def turned(
    name: str, on_map: Sequence[Feature], off_map: Sequence[Feature], terrain: Terrain
) -> Iterator[Remark]:
    """Yield remarks on zones whose edges may be meant to go the long way round."""
    short = [feature.label for feature in on_map if goes_short_way(feature)]
    if short:
        yield Remark(
            Grade.NOTE,
            f"{name}: an edge of more than 180 degrees of longitude goes the short way round the "
            f"Earth, across the meridian of 180 degrees: {labelled(short)}.",
        )
    away = long_way_on_map(off_map, terrain)
    labels = [feature.label for feature in itertools.compress(off_map, away)]
    if labels:
        yield Remark(
            Grade.WARNING,
            f"{name}: an edge of more than 180 degrees of longitude went the short way round the "
            f"Earth, across the meridian of 180 degrees, so its zone misses the map; divide the "
            f"edge if the long way is meant: {labelled(labels)}.",
        )


def tangled(name: str, features: Iterable[tuple[Feature, Sequence[Placed]]]) -> Iterator[Remark]:
    """Yield a warning for zones whose outlines cross themselves or enclose ground twice."""
    by_kind: dict[bool, list[str]] = {}
    for feature, parts in features:
        if any(part.is_tangled for part in parts):
            by_kind.setdefault(feature.keeps_in, []).append(feature.label)
    for keeps_in, labels in by_kind.items():
        counts = "outside and forbidden" if keeps_in else "inside and forbidden"
        yield Remark(
            Grade.WARNING,
            f"{name}: the outline crosses itself or is drawn twice, and ground that it encloses "
            f"twice counts as {counts}; draw it once around its area: {labelled(labels)}.",
        )


def in_degrees(name: str, features: Iterable[Feature], terrain: Terrain) -> Iterator[Remark]:
    """Yield a warning for zones in local metres whose numbers look like degrees."""
    found = []
    for feature in features:
        x, y = zip(*feature.rings[0], strict=True)
        if not feature.is_local or not _are_degrees(x, y):
            continue
        extent_m = math.hypot(max(x) - min(x), max(y) - min(y))
        size = f"{extent_m:.2g} m wide" if feature.radius_m is None else "near a corner of the map"
        is_small = feature.radius_m is None and extent_m < _SMALL_M
        if is_small or in_degrees_on_map(feature, terrain):
            found.append(f"{feature.label} is {size}")
    if found:
        yield Remark(
            Grade.WARNING,
            f"{name}: crs_local is true, so coordinates are metres, but some look like degrees: "
            f"{labelled(found)}; remove crs_local if they are longitudes and latitudes.",
        )


def _are_degrees(x: Sequence[float], y: Sequence[float]) -> bool:
    """Return whether numbers may be longitudes and latitudes, in either order."""
    most = max(map(abs, x)), max(map(abs, y))
    return max(most) <= _DEGREES[0] and min(most) <= _DEGREES[1]


def labelled(labels: Iterable[str]) -> str:
    """Return names for a sentence, each once: the first ones, and the number of the rest."""
    listed = list(dict.fromkeys(labels))
    more = f" and {len(listed) - _NAMES} more" if len(listed) > _NAMES else ""
    return f"{', '.join(listed[:_NAMES])}{more}"
