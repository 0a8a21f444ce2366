"""Reading of zone files: features are placed over a terrain, with a report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Any, Generic, TypeVar

from pathgene.host.errors import InputError
from pathgene.host.formats.classes import DEFAULT, forbids
from pathgene.host.formats.features import Bad, Feature, LeftOut, Reference
from pathgene.host.formats.registry import read_features
from pathgene.host.formats.shapes import Shape
from pathgene.host.problem.active_times import LONGEST_S, Interval, intervals
from pathgene.host.problem.heights import Band, Heights, Stated, encloses_nothing, follows_ground
from pathgene.host.problem.placing import Placed, Swapped, place, swapped_on_map
from pathgene.host.problem.rings import require_corners
from pathgene.host.problem.zone_report import Record, report, touches
from pathgene.host.remarks import Grade, Reading, Remark
from pathgene.host.terrain import Terrain


__all__ = ["Intake", "ZoneOptions", "intake"]

# Distance in degrees within which a place and the same place with swapped coordinates are
# neighbours.
_NEIGHBOURS_DEG = 2.0
_SWAP = "swap them in the file, or in --origin LAT,LON if you gave it."


@dataclass(frozen=True)
class ZoneOptions:
    """The user's choices for reading zones.

    Parameters
    ----------
    skip_bad : bool
        Read a file without its bad features, which are then left out.
    forbid : frozenset of str, optional
        Classes of airspace that forbid; None for the defaults of the formats.
    departure : datetime, optional
        Moment at which the path starts, with a time zone.
    qnh_hpa : float, optional
        Pressure at sea level, for flight levels.
    ceiling_m : float, optional
        Maximum altitude of the flight, for the report.
    longest_s : float
        Maximum duration of the flight, seconds; a zone that is active only later does not forbid.
    """

    skip_bad: bool = False
    forbid: frozenset[str] | None = None
    departure: datetime | None = None
    qnh_hpa: float | None = None
    ceiling_m: float | None = None
    longest_s: float = LONGEST_S


Z = TypeVar("Z")


@dataclass
class Intake(Generic[Z]):
    """Zones of a file, with the omitted parts and the report."""

    zones: list[Z] = field(default_factory=list)
    left_out: list[LeftOut] = field(default_factory=list)
    reading: Reading = field(default_factory=Reading)


def intake(
    path: str | Path,
    terrain: Terrain,
    options: ZoneOptions,
    make: Callable[[Shape], Z],
) -> Intake[Z]:
    """Read a file, and make a zone of each part of a feature that lies near the map.

    Raises
    ------
    InputError
        If the file cannot be read, has a bad feature that is not to be skipped, or has positions in
        degrees although the terrain has no place on Earth.
    """
    kind, items = read_features(path)
    try:
        return _taken(Path(path).name, kind, list(items), terrain, options, make)
    except InputError as error:
        raise InputError(f"No-fly file {str(path)!r}: {error}") from None


def _taken(
    name: str,
    kind: str,
    items: Sequence[Feature | LeftOut | Bad],
    terrain: Terrain,
    options: ZoneOptions,
    make: Callable[[Shape], Z],
) -> Intake[Z]:
    features: list[Feature] = []
    bad: list[Bad] = []
    taken: Intake[Z] = Intake()
    for item in items:
        if isinstance(item, LeftOut):
            taken.left_out.append(item)
        elif isinstance(item, Bad):
            bad.append(item)
        elif (fault := _fault(item)) is not None:
            bad.append(Bad(item.label, fault))
        else:
            features.append(_chosen(item, options.forbid))
    if terrain.crs is None and not all(feature.is_local for feature in features):
        raise InputError(
            f"the terrain has no coordinate reference system, so {kind} has no place on it; give "
            "--origin LAT,LON, or origin under [terrain] in a problem file, or zones in local "
            'metres as GeoJSON with the member "crs_local": true.'
        )
    # Outlines are compared with themselves, so too many corners are refused first.
    require_corners(sum(len(ring) for own in features if own.is_local for ring in own.rings))
    placed = place(features, terrain)
    require_corners(sum(len(ring) for own in placed for part in own for ring in part.rings))
    swapped, doubts = _swapped(features, placed, terrain)
    tiled = sum(
        follows_ground(f) for f, parts in zip(features, placed, strict=True) if f.forbids and parts
    )
    heights = Heights(terrain, options.qnh_hpa, tiled)
    records: list[Record] = []
    for number, (feature, parts) in enumerate(zip(features, placed, strict=True)):
        try:
            if number in swapped:
                raise InputError(swapped[number])
            record, zones = _zones(feature, parts, heights, options, make)
        except InputError as error:
            bad.append(Bad(feature.label, str(error)))
        else:
            records.append(record)
            taken.zones += zones
    if bad and not options.skip_bad:
        raise InputError(_refusal(bad, len(items)))
    taken.left_out += [LeftOut(each.label, each.reason.rstrip("."), True) for each in bad]
    taken.reading = report(
        name,
        kind,
        records,
        taken.left_out,
        terrain,
        ceiling_m=options.ceiling_m,
        departure=options.departure,
        has_qnh=options.qnh_hpa is not None,
    ).adding(doubts)
    return taken


def _chosen(feature: Feature, forbid: frozenset[str] | None) -> Feature:
    """Return a feature that forbids according to the user's choice, if it has a category."""
    category, airspace_class = feature.category, feature.airspace_class
    if forbid is not None and category:
        does = forbids(category, forbid, airspace_class=airspace_class)
        feature = replace(feature, forbids=does)
    chosen = DEFAULT if forbid is None else forbid
    if airspace_class and feature.forbids and not forbids(category, chosen):
        text = f"its type {category} does not forbid flight, but its class {airspace_class} does"
        feature = replace(feature, remarks=(*feature.remarks, Remark(Grade.NOTE, text)))
    return feature


def _zones(
    feature: Feature,
    parts: tuple[Placed, ...],
    heights: Heights,
    options: ZoneOptions,
    make: Callable[[Shape], Z],
) -> tuple[Record, list[Z]]:
    """Return the record of a feature, and its zones: one for each part and time."""
    bands = [(part, heights.bands(feature, part)) for part in parts]
    times: Sequence[Interval] = [(feature.t0_s, feature.t1_s)]
    if feature.periods and options.departure is not None:
        corners = [corner for ring in feature.rings for corner in ring]
        times = intervals(feature.periods, options.departure, corners, options.longest_s)
    every = tuple(band for _, some in bands for band in some)
    _check_order(feature, parts, every, heights.terrain)
    is_active = any((first or 0.0) <= options.longest_s for first, _ in times)
    record = Record(feature, parts, every, is_active)
    if not feature.forbids or encloses_nothing(feature):
        return record, []
    converted = any(
        limit is not None and limit.reference is not Reference.AMSL
        for limit in (feature.lower, feature.upper)
    )
    zones = [
        make(_shape(feature, part, heights.stated(feature, some), interval))
        for part, some in bands
        # If limits with the same reference enclose nothing, the file is faulty.
        if not (converted and all(band.is_empty for band in some))
        for interval in times
    ]
    return record, zones


def _check_order(
    feature: Feature, parts: Sequence[Placed], bands: Sequence[Band], terrain: Terrain
) -> None:
    """Check that a zone which forbids is not upside down wherever it lies on the map.

    Raises
    ------
    InputError
        If it is; limits of two references are compared over the ground of the map.
    """
    lower, upper = feature.lower, feature.upper
    if not feature.forbids or lower is None or upper is None or lower == upper:
        return
    if lower.reference is upper.reference:
        is_reversed, where = lower.height_m > upper.height_m, ""
    else:
        is_on_map = any(touches(part, terrain) for part in parts)
        is_reversed, where = is_on_map and all(band.is_empty for band in bands), " on this map"
    if is_reversed:
        raise InputError(
            f"its lower limit, {lower.described}, lies above its upper, {upper.described}{where}."
        )


def _fault(feature: Feature) -> str | None:
    """Return the fault of a feature's rings, if there is one."""
    if feature.radius_m is not None:
        return None if feature.radius_m >= 0 else f"radius_m is negative, {feature.radius_m:g}."
    short = min(map(len, feature.rings))
    return None if short >= 3 else f"a ring must have at least 3 corners, not {short}."


def _refusal(bad: Sequence[Bad], total: int) -> str:
    """Return the message about bad features: the first one, and the option that skips them."""
    text = f"{bad[0].label}: {bad[0].reason}"
    if bad[0].reason.endswith(_SWAP):
        return f"{text.rstrip('.')}, or leave it out by --skip-bad-zones."
    if len(bad) < total:
        others = f" and {len(bad) - 1} more are bad" if len(bad) > 1 else ""
        text = f"{text.rstrip('.')}{others}; --skip-bad-zones reads the other {total - len(bad)}."
    return text


def _swapped(
    features: Sequence[Feature], placed: Sequence[tuple[Placed, ...]], terrain: Terrain
) -> tuple[dict[int, str], list[Remark]]:
    """Return the fault of features off the map that would be on it with swapped coordinates.

    An area of a country that would cover the map gets a warning, as it is rather another country.
    """
    off = [
        number
        for number, (feature, parts) in enumerate(zip(features, placed, strict=True))
        if not feature.is_local and _is_off(feature, parts, terrain)
    ]
    some_on_map = len(off) < len(features)
    found, doubts = {}, []
    where = swapped_on_map([features[number] for number in off], terrain)
    for number, swapped in zip(off, where, strict=True):
        if swapped is Swapped.OFF:
            continue
        longitude, latitude = features[number].rings[0][0]
        if some_on_map and abs(longitude - latitude) < _NEIGHBOURS_DEG:
            continue
        if swapped is Swapped.AROUND:
            if features[number].forbids:
                text = (
                    f"{features[number].label} lies off the map, at latitude {latitude:g} and "
                    f"longitude {longitude:g}, and would cover all of it with the two swapped; "
                    "swap them in the file if it belongs here."
                )
                doubts.append(Remark(Grade.WARNING, text))
            continue
        found[number] = (
            f"it lies off the map, at latitude {latitude:g} and longitude {longitude:g}, and on "
            f"the map with the two swapped; {_SWAP}"
        )
    return found, doubts


def _is_off(feature: Feature, parts: Sequence[Placed], terrain: Terrain) -> bool:
    """Return whether a feature lies off the map."""
    if feature.keeps_in:
        # The zone is the whole map; a fence near it is a hole.
        return all(len(part.rings) == 1 for part in parts)
    return not any(touches(part, terrain) for part in parts)


def _shape(
    feature: Feature, part: Placed, limits: tuple[Stated, Stated], interval: Interval
) -> Shape:
    """Return a part of a feature with the properties of a zone."""
    properties: dict[str, Any] = {
        "name": feature.name,
        "lower": limits[0],
        "upper": limits[1],
        "t0": interval[0],
        "t1": interval[1],
    }
    if part.radius_m is not None:
        return Shape("Point", part.rings, {**properties, "radius_m": part.radius_m})
    return Shape("Polygon", part.rings, properties)
