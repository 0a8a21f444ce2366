"""The report on a file of zones: zones on the map, zones that can forbid, omitted parts."""

from __future__ import annotations

import itertools
import math
import operator
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

from pathgene.host.formats.features import Feature, LeftOut, Reference
from pathgene.host.formats.shapes import Ring
from pathgene.host.problem.active_times import described
from pathgene.host.problem.edges import clipped
from pathgene.host.problem.heights import Band, encloses_nothing, follows_ground, ground_under
from pathgene.host.problem.placing import Placed
from pathgene.host.problem.zone_doubts import (
    in_degrees,
    labelled,
    mirrored,
    of_corners,
    of_holes,
    of_size,
    tangled,
    turned,
)
from pathgene.host.remarks import Grade, Reading, Remark
from pathgene.host.terrain import Terrain


__all__ = ["OFF_THE_MAP", "Record", "powerless", "report", "touches"]

# Square metres of a zone without a size.
_NO_AREA_M2 = 1e-6
# Reason for features that lie elsewhere, which are counted but rarely named.
OFF_THE_MAP = "it lies off the map"


@dataclass(frozen=True)
class Record:
    """A feature with its zones.

    Parameters
    ----------
    feature : Feature
        The feature.
    parts : tuple of Placed
        Its parts near the map.
    bands : tuple of Band
        The parts, or their tiles, with limits.
    is_active : bool
        False if its times end before the flight or begin after it.
    """

    feature: Feature
    parts: tuple[Placed, ...] = ()
    bands: tuple[Band, ...] = field(default=())
    is_active: bool = True

    def reason(self, terrain: Terrain, ceiling_m: float | None) -> str:
        """Return the reason why the feature cannot forbid anything; empty if it can."""
        if not any(touches(part, terrain) for part in self.parts):
            return OFF_THE_MAP
        if all(_area_m2(part) < _NO_AREA_M2 for part in self.parts):
            return "it has no size"
        if not self.is_active:
            return "it is not active during the flight"
        if self.feature.lower is not None and self.feature.lower == self.feature.upper:
            return "its lower limit is its upper limit"
        if encloses_nothing(self.feature) or all(band.is_empty for band in self.bands):
            return "its lower limit is not below its upper limit"
        upper = self.feature.upper
        is_ground = upper and upper.reference is Reference.AGL and upper.height_m <= 0
        if is_ground or all(_is_below(band, terrain) for band in self.bands):
            return "its upper limit is under the ground everywhere"
        lowest = [-math.inf if band.lower_m is None else band.lower_m for band in self.bands]
        if ceiling_m is not None and min(lowest) >= ceiling_m:
            return f"its lower limit is over the ceiling of {ceiling_m:g} m everywhere"
        return ""

    def to_dict(self, reason: str) -> dict[str, Any]:
        """The feature as in ``summary.json``."""
        feature = self.feature
        lows = [band.lower_m for band in self.bands]
        highs = [band.upper_m for band in self.bands]
        return {
            "part": feature.label,
            "name": feature.name,
            "category": feature.category,
            "class": feature.airspace_class,
            "lower": None if feature.lower is None else feature.lower.described,
            "upper": None if feature.upper is None else feature.upper.described,
            "lower_m": _outermost(lows, min),
            "upper_m": _outermost(highs, max),
            "times": described(feature.periods) or _seconds(feature.t0_s, feature.t1_s),
            "forbids": not reason,
            "reason": reason,
        }


def _seconds(first: float | None, last: float | None) -> str:
    """Return seconds of the flight in words; empty for always."""
    bounds = (("from", first), ("until", last))
    words = ", ".join(f"{word} {bound:g} s" for word, bound in bounds if bound is not None)
    return f"{words} of the flight" if words else ""


def _outermost(
    limits: Sequence[float | None], choose: Callable[[Iterable[float]], float]
) -> float | None:
    """Return the outermost limit of the tiles; None if one tile has no limit."""
    known = [limit for limit in limits if limit is not None]
    return choose(known) if known and len(known) == len(limits) else None


def touches(part: Placed, terrain: Terrain) -> bool:
    """Return whether a part has a point in common with the map."""
    if part.radius_m is not None:
        ((x, y),) = part.rings[0]
        away = math.hypot(max(-x, x - terrain.width_m, 0.0), max(-y, y - terrain.height_m, 0.0))
        return away <= part.radius_m
    return len(clipped(part.rings[0], (0.0, 0.0, terrain.width_m, terrain.height_m))) > 0


def _area_m2(part: Placed) -> float:
    if part.radius_m is not None:
        return math.pi * part.radius_m**2
    return abs(_signed_area_m2(part.rings[0]))


def _signed_area_m2(ring: Ring) -> float:
    """Return the area of a ring, or its extent if it crosses itself and its halves cancel out."""
    x0, y0 = ring[0]
    moved = [(x - x0, y - y0) for x, y in ring]
    # Triangles are added one by one, so a figure of eight has an area.
    return sum(abs(xa * yb - xb * ya) for (xa, ya), (xb, yb) in itertools.pairwise(moved))


def _is_below(band: Band, terrain: Terrain) -> bool:
    """Return whether the upper limit is below the ground everywhere."""
    return band.upper_m is not None and band.upper_m <= ground_under(band.part, terrain)[0]


def powerless(
    records: Sequence[Record], terrain: Terrain, ceiling_m: float | None
) -> Iterator[Remark]:
    """Yield a warning for each reason why zones that are not of a file forbid nothing."""
    reasons = [record.reason(terrain, ceiling_m) for record in records]
    yield from _powerless("", records, reasons, False)


def report(
    name: str,
    kind: str,
    records: Sequence[Record],
    left_out: Sequence[LeftOut],
    terrain: Terrain,
    *,
    ceiling_m: float | None,
    departure: datetime | None,
    has_qnh: bool,
) -> Reading:
    """Return the facts of a file and the remarks on them."""
    reasons = [
        record.reason(terrain, ceiling_m) if record.feature.forbids else "" for record in records
    ]
    forbidding = [record for record in records if record.feature.forbids]
    are_on_map = [
        reason != OFF_THE_MAP and any(touches(part, terrain) for part in record.parts)
        for record, reason in zip(records, reasons, strict=True)
    ]
    on_map = list(itertools.compress(records, are_on_map))
    off_map = list(itertools.compress(records, map(operator.not_, are_on_map)))
    able = [
        record
        for record, reason in zip(records, reasons, strict=True)
        if record.feature.forbids and not reason
    ]
    facts: dict[str, Any] = {
        "format": kind,
        "read": len(records),
        "on_map": len(on_map),
        "can_forbid": len(able),
        "zones": [
            record.to_dict(reason if record.feature.forbids else "its category does not forbid")
            for record, reason, is_on_map in zip(records, reasons, are_on_map, strict=True)
            if is_on_map
        ],
        "left_out": [{"part": each.label, "reason": each.reason} for each in left_out],
    }
    categories = dict.fromkeys(record.feature.category for record in records)
    if any(categories):
        facts["categories"] = {
            category or "none": {
                "read": sum(r.feature.category == category for r in records),
                "forbid": sum(r.feature.category == category for r in forbidding),
            }
            for category in categories
        }
    remarks = [
        *_counts(name, kind, len(records), len(on_map), len(able)),
        *_categories(name, records),
        *_powerless(name, records, reasons, bool(on_map)),
        *turned(name, [r.feature for r in on_map], [r.feature for r in off_map], terrain),
        *in_degrees(name, [r.feature for r in records], terrain),
        *_left_out(name, left_out),
        *_unread(name, [record for record in on_map if record.feature.forbids]),
        *tangled(name, [(r.feature, r.parts) for r in able]),
        *mirrored(name, [] if on_map else [r.feature for r in off_map], terrain),
        *of_corners(name, [r.feature for r in on_map]),
        *of_holes(name, [r.feature for r in on_map if r.feature.forbids]),
        *of_size(name, [r.feature for r in on_map if r.feature.forbids]),
        *_own_remarks(name, on_map),
        *_plain_times(name, [record for record in on_map if record.feature.forbids]),
        *_validity(name, on_map, departure),
        *_assumed(name, able, terrain, has_departure=departure is not None, has_qnh=has_qnh),
    ]
    return Reading(facts, tuple(remarks))


def _counts(name: str, kind: str, read: int, on_map: int, able: int) -> Iterator[Remark]:
    touching = "touches" if on_map == 1 else "touch"
    yield Remark(
        Grade.NOTE if able else Grade.WARNING,
        f"{name}: {_count(read, 'zone')} read as {kind}; {on_map} {touching} the map, "
        f"{able} can forbid flight.",
    )


def _categories(name: str, records: Sequence[Record]) -> Iterator[Remark]:
    """Yield the note on features that inform only."""
    open_ = [record.feature for record in records if not record.feature.forbids]
    if open_:
        kinds = ", ".join(sorted(set(map(_category, open_))))
        yield Remark(
            Grade.NOTE,
            f"{name}: {_count(len(open_), 'zone')} of a category that does not forbid ({kinds}): "
            f"{labelled(feature.label for feature in open_)}; --forbid changes this.",
        )


def _category(feature: Feature) -> str:
    category, airspace_class = feature.category or "none", feature.airspace_class
    return f"{category} of class {airspace_class}" if airspace_class else category


def _powerless(
    name: str, records: Sequence[Record], reasons: Sequence[str], some_on_map: bool
) -> Iterator[Remark]:
    """Yield a warning for each reason why zones forbid nothing."""
    file = f"{name}: " if name else ""
    by_reason: dict[str, list[str]] = {}
    for record, reason in zip(records, reasons, strict=True):
        if reason:
            by_reason.setdefault(reason, []).append(record.feature.label)
    for reason, labels in by_reason.items():
        # Files of a whole country have many zones elsewhere.
        grade = Grade.NOTE if reason == OFF_THE_MAP and some_on_map else Grade.WARNING
        verb = "forbids" if len(labels) == 1 else "forbid"
        why = reason if len(labels) == 1 else _plural(reason)
        text = f"{file}{labelled(labels)} {verb} nothing: {why}."
        yield Remark(grade, f"{text[:1].upper()}{text[1:]}" if not file else text)


def _plural(reason: str) -> str:
    """Return a reason for several zones."""
    for one, many in (
        ("it lies", "they lie"),
        ("it has", "they have"),
        ("it is", "they are"),
        ("its lower limit is not below its upper limit", "no lower limit is below its upper limit"),
        ("its lower limit is its upper limit", "their lower limits are their upper limits"),
        ("its lower limit is", "their lower limits are"),
        ("its upper limit is", "their upper limits are"),
    ):
        if reason.startswith(one):
            return many + reason.removeprefix(one)
    return reason


def _left_out(name: str, left_out: Iterable[LeftOut]) -> Iterator[Remark]:
    """Yield one remark for each reason why parts of the file are not zones."""
    by_reason: dict[tuple[str, bool], list[str]] = {}
    for each in left_out:
        by_reason.setdefault((each.reason, each.is_suspicious), []).append(each.label)
    for (reason, is_suspicious), labels in by_reason.items():
        grade = Grade.WARNING if is_suspicious else Grade.NOTE
        yield Remark(grade, f"{name}: {labelled(labels)} left out: {reason}.")


def _unread(name: str, records: Iterable[Record]) -> Iterator[Remark]:
    """Yield a warning for each set of properties that may limit zones but are not read."""
    by_names: dict[tuple[str, ...], list[str]] = {}
    for record in records:
        if record.feature.unread:
            by_names.setdefault(record.feature.unread, []).append(record.feature.label)
    for names, labels in by_names.items():
        verb = "is" if len(names) == 1 else "are"
        yield Remark(
            Grade.WARNING,
            f"{name}: {', '.join(names)} of {labelled(labels)} {verb} not read, so nothing is "
            "limited by it.",
        )


def _own_remarks(name: str, records: Iterable[Record]) -> Iterator[Remark]:
    """Yield the remarks of the format on zones, each once with all its zones."""
    by_remark: dict[Remark, list[str]] = {}
    for record in records:
        for remark in record.feature.remarks:
            by_remark.setdefault(remark, []).append(record.feature.label)
    for remark, labels in by_remark.items():
        yield Remark(remark.grade, f"{name}: {labelled(labels)}: {remark.text}.")


def _plain_times(name: str, records: Iterable[Record]) -> Iterator[Remark]:
    """Yield a warning for zones with times that have no time zone: local time may be meant."""
    plain = [
        record.feature.label
        for record in records
        if any(period.has_plain_times for period in record.feature.periods)
    ]
    if plain:
        yield Remark(
            Grade.WARNING,
            f"{name}: times without a time zone count as UTC: {labelled(plain)}.",
        )


def _validity(name: str, records: Iterable[Record], departure: datetime | None) -> Iterator[Remark]:
    """Yield a remark for each validity of a file that is over, not begun or not compared."""
    for valid in dict.fromkeys(record.feature.valid for record in records):
        if valid is None:
            continue
        stated = f"{name}: states that it is valid {described((valid,))}"
        if departure is None:
            yield Remark(Grade.NOTE, f"{stated}, which is not compared without --departure.")
        elif valid.end is not None and valid.end < departure:
            yield Remark(
                Grade.WARNING, f"{stated}, before the departure; its zones count all the same."
            )
        elif valid.start is not None and valid.start > departure:
            yield Remark(
                Grade.WARNING, f"{stated}, after the departure; its zones count all the same."
            )


def _assumed(
    name: str,
    records: Sequence[Record],
    terrain: Terrain,
    *,
    has_departure: bool,
    has_qnh: bool,
) -> Iterator[Remark]:
    """Yield notes on the conversion of heights and times."""
    above_ground = [r.feature.label for r in records if follows_ground(r.feature)]
    if above_ground:
        yield Remark(
            Grade.NOTE,
            f"{name}: limits above the ground follow the ground tile by tile, on the safe side: "
            f"{labelled(above_ground)}.",
        )
    levels = [r.feature.label for r in records if _refers(r.feature, Reference.STANDARD)]
    if levels and not has_qnh:
        yield Remark(
            Grade.NOTE,
            f"{name}: flight levels count for any pressure at sea level from 950 to 1050 hPa; give "
            f"the pressure by --qnh: {labelled(levels)}.",
        )
    ellipsoidal = [r.feature.label for r in records if _refers(r.feature, Reference.WGS84)]
    if ellipsoidal:
        from pathgene.host.problem.heights import geoid_m

        low, high = geoid_m(terrain)
        yield Remark(
            Grade.NOTE,
            f"{name}: heights above the ellipsoid count with a geoid from {low:g} to {high:g} m "
            f"above it: {labelled(ellipsoidal)}.",
        )
    timed = [r.feature.label for r in records if r.feature.periods]
    if timed and not has_departure:
        yield Remark(
            Grade.NOTE,
            f"{name}: zones that are active at times count as always active without --departure: "
            f"{labelled(timed)}.",
        )


def _refers(feature: Feature, reference: Reference) -> bool:
    limits = (feature.lower, feature.upper)
    return any(limit is not None and limit.reference is reference for limit in limits)


def _count(count: int, word: str) -> str:
    return f"{count} {word}" if count == 1 else f"{count} {word}s"
