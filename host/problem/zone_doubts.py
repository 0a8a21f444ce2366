"""Doubts about zones: outlines, ways around the Earth, degrees taken as metres, odd sizes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from pathgene.host.formats.features import Feature, Position, Reference
from pathgene.host.problem.edges import unwrapped
from pathgene.host.problem.loops import is_inside
from pathgene.host.problem.placing import (
    Placed,
    goes_short_way,
    in_degrees_on_map,
    is_mirrored_on_map,
    long_way_on_map,
)
from pathgene.host.remarks import Grade, Remark
from pathgene.host.terrain import Terrain


__all__ = [
    "in_degrees",
    "labelled",
    "mirrored",
    "of_corners",
    "of_holes",
    "of_size",
    "tangled",
    "turned",
]

# Names in one sentence.
_NAMES = 5
# Extent in metres below which nobody draws a zone, and the largest longitude and latitude.
_SMALL_M, _DEGREES = 5.0, (180.0, 90.0)
# Radii below and above which a unit of the file is doubtful, metres; greatest doubtful upper limit
# above the ground, and least doubtful lower limit.
_SMALL_RADIUS_M, _LARGE_RADIUS_M = 10.0, 500_000.0
_LOW_M, _HIGH_M = 5.0, 20_000.0
# Degrees by which a corner lies far from all other corners, which are this many times nearer.
_FAR_DEG, _NEARER = 1.0, 20.0


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


def of_corners(name: str, features: Iterable[Feature]) -> Iterator[Remark]:
    """Yield a warning for zones of which a corner lies far from all other corners."""
    found = [feature.label for feature in features if _has_stray_corner(feature)]
    if found:
        yield Remark(
            Grade.WARNING,
            f"{name}: one corner lies more than {_FAR_DEG:g} degree from all other corners, "
            f"which are near each other; correct its longitude or latitude: {labelled(found)}.",
        )


def _has_stray_corner(feature: Feature) -> bool:
    ring = list(dict.fromkeys(feature.rings[0]))
    if feature.is_local or len(ring) < 4:
        return False
    corners = np.array(unwrapped(ring))
    away = np.abs(corners - np.median(corners, axis=0)).max(axis=1)
    *_, near, far = np.sort(away)
    return bool(far > max(_FAR_DEG, _NEARER * near))


def mirrored(name: str, off_map: Sequence[Feature], terrain: Terrain) -> Iterator[Remark]:
    """Yield a warning for zones off the map that changed signs would place on it."""
    found = [feature.label for feature in off_map if is_mirrored_on_map(feature, terrain)]
    if found:
        yield Remark(
            Grade.WARNING,
            f"{name}: with another sign of longitude or latitude, the zone would be on the map; "
            f"check east and west, and north and south: {labelled(found)}.",
        )


def of_holes(name: str, features: Iterable[Feature]) -> Iterator[Remark]:
    """Yield warnings of zones whose holes lie outside their outline, or around it."""
    outside: list[str] = []
    around: list[str] = []
    for feature in features:
        outer, *holes = map(unwrapped, feature.rings)
        if not holes or feature.keeps_in:
            continue
        # Corners of a hole may lie on the outline.
        samples = np.array([_third(hole) for hole in holes])
        is_in = is_inside(outer, samples.reshape(-1, 2)).reshape(len(holes), -1)
        for hole, inner in zip(holes, is_in, strict=True):
            if not inner.any() and frozenset(hole) != frozenset(outer):
                holds = is_inside(hole, np.array(_third(outer))).any()
                (around if holds else outside).append(feature.label)
    for labels, text in (
        (outside, "a hole lies outside the outline and is forbidden, too; make it a polygon"),
        (around, "a hole lies around the outline, so the ground between is forbidden; swap them"),
    ):
        if labels:
            yield Remark(Grade.WARNING, f"{name}: {text}: {labelled(labels)}.")


def _third(ring: Sequence[Position]) -> tuple[Position, Position, Position]:
    """Return three corners of a ring, far from each other."""
    return ring[0], ring[len(ring) // 3], ring[2 * len(ring) // 3]


def of_size(name: str, features: Iterable[Feature]) -> Iterator[Remark]:
    """Yield warnings of zones whose radius or limits look like another unit."""
    by_doubt: dict[str, list[str]] = {}
    for feature in features:
        for doubt in _odd_sizes(feature):
            by_doubt.setdefault(doubt, []).append(feature.label)
    for doubt, labels in by_doubt.items():
        yield Remark(Grade.WARNING, f"{name}: {labelled(labels)}: {doubt}.")


def _odd_sizes(feature: Feature) -> Iterator[str]:
    radius_m, lower, upper = feature.radius_m, feature.lower, feature.upper
    if radius_m is not None and not feature.is_local:
        if 0 < radius_m < _SMALL_RADIUS_M:
            yield f"its radius is {radius_m:g} m; kilometres or nautical miles may be meant"
        elif radius_m > _LARGE_RADIUS_M:
            yield f"its radius is {radius_m / 1000:,.0f} km; metres may be meant"
    if upper is not None and upper.reference is Reference.AGL and 0 < upper.height_m < _LOW_M:
        yield f"its upper limit is {upper.described}, so it forbids little; correct its unit"
    if lower is not None and lower.height_m > _HIGH_M:
        yield f"its lower limit is {lower.described}, over all flights; correct its unit"


def _are_degrees(x: Sequence[float], y: Sequence[float]) -> bool:
    """Return whether numbers may be longitudes and latitudes, in either order."""
    most = max(map(abs, x)), max(map(abs, y))
    return max(most) <= _DEGREES[0] and min(most) <= _DEGREES[1]


def labelled(labels: Iterable[str]) -> str:
    """Return names for a sentence, each once: the first ones, and the number of the rest."""
    listed = list(dict.fromkeys(labels))
    more = f" and {len(listed) - _NAMES} more" if len(listed) > _NAMES else ""
    return f"{', '.join(listed[:_NAMES])}{more}"
