"""Reading of zone files: features are placed over a terrain, with a report."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from pathgene.host.errors import InputError
from pathgene.host.formats.features import Bad, Feature, LeftOut
from pathgene.host.formats.registry import read_features
from pathgene.host.formats.shapes import Shape
from pathgene.host.problem.footprints import Footprint
from pathgene.host.problem.heights import metres
from pathgene.host.problem.placing import Placed, place
from pathgene.host.remarks import Grade, Reading, Remark
from pathgene.host.terrain import Terrain


__all__ = ["Intake", "ZoneOptions", "intake"]


@dataclass(frozen=True)
class ZoneOptions:
    """Choices of the user on how zones are read.

    Parameters
    ----------
    skip_bad : bool
        Read a file without its bad features, which are then left out.
    forbid : tuple of str, optional
        Categories that forbid; None for the defaults of the formats.
    departure : datetime, optional
        Moment at which the path starts, with a time zone.
    qnh_hpa : float, optional
        Pressure at sea level, for flight levels.
    ceiling_m : float, optional
        Maximum altitude of the flight, for the report.
    """

    skip_bad: bool = False
    forbid: tuple[str, ...] | None = None
    departure: datetime | None = None
    qnh_hpa: float | None = None
    ceiling_m: float | None = None


class _Zone(Protocol):
    """The fields of a zone that the report needs."""

    @property
    def footprint(self) -> Footprint: ...


Z = TypeVar("Z", bound=_Zone)


@dataclass
class Intake(Generic[Z]):
    """Zones of a file, with the parts that are left out and the report on them."""

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
        If the file cannot be read, has a bad feature that is not to be skipped, or has positions
        in degrees where the terrain has no place on Earth.
    """
    kind, items = read_features(path)
    try:
        return _taken(kind, list(items), terrain, options, make)
    except InputError as error:
        raise InputError(f"No-fly file {str(path)!r}: {error}") from None


def _taken(
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
            features.append(item)
    if terrain.crs is None and not all(feature.is_local for feature in features):
        raise InputError(
            f"the terrain has no coordinate reference system, so {kind} has no place on it; give "
            "--origin LAT,LON, or origin under [terrain] in a problem file, or zones in local "
            'metres as GeoJSON with the member "crs_local": true.'
        )
    for feature, parts in zip(features, place(features, terrain), strict=True):
        try:
            taken.zones += [make(_shape(feature, part, terrain)) for part in parts]
        except InputError as error:
            bad.append(Bad(feature.label, str(error)))
    if bad and not options.skip_bad:
        raise InputError(_refusal(bad, len(items)))
    taken.left_out += [LeftOut(each.label, each.reason.rstrip("."), True) for each in bad]
    taken.reading = Reading(
        {
            "features": len(features),
            "left_out": [{"part": each.label, "reason": each.reason} for each in taken.left_out],
        },
        tuple(_remarks(taken.left_out)),
    )
    return taken


def _fault(feature: Feature) -> str | None:
    """Return the fault of a feature's rings, if there is one."""
    if feature.radius_m is not None:
        return None if feature.radius_m >= 0 else f"radius_m is negative, {feature.radius_m:g}."
    short = min(map(len, feature.rings))
    return None if short >= 3 else f"a ring must have at least 3 corners, not {short}."


def _refusal(bad: Sequence[Bad], total: int) -> str:
    """Return the sentence on bad features: the first one, and the option that skips them."""
    text = f"{bad[0].label}: {bad[0].reason}"
    if len(bad) < total:
        others = f" and {len(bad) - 1} more are bad" if len(bad) > 1 else ""
        text = f"{text.rstrip('.')}{others}; --skip-bad-zones reads the other {total - len(bad)}."
    return text


def _shape(feature: Feature, part: Placed, terrain: Terrain) -> Shape:
    """Return a part of a feature with the properties of a zone."""
    lower_m, upper_m = metres(feature.lower, feature.upper, part, terrain)
    properties: dict[str, Any] = {
        "name": feature.name,
        "lower": lower_m,
        "upper": upper_m,
        "t0": feature.t0_s,
        "t1": feature.t1_s,
    }
    if part.radius_m is not None:
        return Shape("Point", part.rings, {**properties, "radius_m": part.radius_m})
    return Shape("Polygon", part.rings, properties)


def _remarks(left_out: Iterable[LeftOut]) -> Iterable[Remark]:
    """Yield one remark for each reason."""
    by_reason: dict[tuple[str, bool], list[str]] = {}
    for each in left_out:
        by_reason.setdefault((each.reason, each.is_suspicious), []).append(each.label)
    for (reason, is_suspicious), labels in by_reason.items():
        more = f" and {len(labels) - 3} more" if len(labels) > 3 else ""
        grade = Grade.WARNING if is_suspicious else Grade.NOTE
        yield Remark(grade, f"Left out: {', '.join(labels[:3])}{more}: {reason}.")
