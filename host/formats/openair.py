"""OpenAir, a text format in which glider pilots exchange airspace, with its version 2 extensions.

An airspace begins with its class (``AC``); its other records state name, type, limits and times
(``A?``) and the outline (``D?``) by means of variables (``V``). The project has its own reader
because the library `aerofiles` drops an airspace for each unknown record.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from pathgene.host.errors import InputError
from pathgene.host.formats import classes
from pathgene.host.formats.arcs import Arc, around, bearing, unwrapped
from pathgene.host.formats.content import Content
from pathgene.host.formats.features import (
    Bad,
    Edges,
    Feature,
    LeftOut,
    Limit,
    Period,
    Position,
    Read,
    label,
)
from pathgene.host.formats.limits import limit_text
from pathgene.host.formats.times import between, moment
from pathgene.host.numeric import parse


__all__ = ["features", "recognises"]

_MILE_M = 1852.0
# Degrees that make less than a millimetre.
_SAME_DEG = 5e-9
# Lines end in LF, CR or both. An airspace without a class is recognised by its name or limits.
_LINE = r"(?i)(?:\A|(?<=[\r\n]))[ \t]*"
_BEGINS = re.compile(rf"{_LINE}(?:AC(?![A-Z])|A[NLH][ \t]+\S)")
_OUTLINES = re.compile(rf"{_LINE}(?:D[PCABY][ \t]+(?:[\d.+-]|[NS][ \t]*\d)|V[ \t]*X[ \t]*=)")
_RECORD = re.compile(r"([A-Za-z]{2}|[Vv])(?![A-Za-z])[ \t]*(.*)")
# Degrees, minutes and seconds with separators, or together as DDMMSS.
_NUMBER = r"(\d+(?:\.\d+)?)"
_BETWEEN = r"(?:\s*[:°'′]\s*|\s+)"
_ANGLE = rf"{_NUMBER}(?:{_BETWEEN}{_NUMBER})?(?:{_BETWEEN}{_NUMBER})?\s*[°'′\"″]{{0,2}}"
_PLACE = re.compile(
    rf"\s*([NS]?)\s*{_ANGLE}\s*([NS]?)[\s,]*([EW]?)\s*{_ANGLE}\s*([EW]?)\s*", re.IGNORECASE
)
# Characters of a place.
_MOST_PLACE = 80
# Digits of a number that has minutes, and of one that has seconds, too.
_WITH_MINUTES, _WITH_SECONDS = 4, 6
# Records that limit no zone: frequency, station, identifier, transponder code, label, colours.
_HARMLESS = frozenset({"AF", "AG", "AI", "AX", "TP", "AT", "AS", "SB", "SP"})

# Mark of a record that belongs to no airspace.
_BEFORE = " before the first AC"

# A part of an outline: a corner, or an arc.
_Part = Position | Arc


@dataclass
class _Airspace:
    """An airspace built from its records."""

    number: int
    line: int
    airspace_class: str
    kind: str = ""
    kind_line: int = 0
    name: str = ""
    limits: dict[str, str] = field(default_factory=dict)
    activations: list[str] = field(default_factory=list)
    outline: list[_Part] = field(default_factory=list)
    circles: list[tuple[Position, float]] = field(default_factory=list)
    airway: list[tuple[Position, float]] = field(default_factory=list)
    clockwise: bool = True
    fault: str = ""

    @property
    def label(self) -> str:
        return label("airspace", self.number, self.name)

    @property
    def has_outline(self) -> bool:
        """True after the first record of an outline, even a bad one."""
        return bool(self.outline or self.circles or self.airway or self.fault)

    @property
    def type_and_class(self) -> tuple[str, str]:
        """The type of version 2 if there is one, and the class."""
        kind = classes.of_word(self.kind) if self.kind else "OTHER"
        return classes.type_and_class(kind, classes.of_word(self.airspace_class))


def recognises(content: Content) -> bool:
    """Return whether a text has the class, name or limit of an airspace, and an outline."""
    return (
        content.json_error is not None
        and not content.is_xml
        and content.is_text
        and _BEGINS.search(content.text) is not None
        and _OUTLINES.search(content.text) is not None
    )


def features(content: Content) -> Iterator[Read]:
    """Yield the airspaces, and the terrain and unknown records as omitted parts."""
    unknown: dict[str, int] = {}
    lines: dict[str, int] = {}
    for part in _airspaces(content.text, unknown):
        if isinstance(part, LeftOut):
            yield part
        else:
            yield from _features(part, lines)
    for name, line in unknown.items():
        if re.fullmatch(rf"D[PCABY]{_BEFORE}", name):
            why = f"the outline has no AC with a class, such as AC D, before its {name[:2]}."
            yield Bad(f"line {line}", why)
        else:
            yield LeftOut(f"line {line}", f"the record {name} is not known")


def _airspaces(text: str, unknown: dict[str, int]) -> Iterator[_Airspace | LeftOut]:
    """Yield the airspaces of a text, and note the unknown records with their first lines."""
    current: _Airspace | None = None
    centre: Position | None = None
    width_m = 0.0
    number, in_terrain = 0, False
    for line, record in enumerate(re.split(r"\r\n|\r|\n", text), start=1):
        stated = record.strip()
        if not stated or stated[0] in "*#;":
            continue
        match = _RECORD.match(stated)
        name = match.group(1).upper() if match else stated[:20]
        value = match.group(2).partition("*")[0].strip() if match else ""
        if name in ("TC", "TO") and current is not None and not current.has_outline:
            # Terrain begins where no airspace is unfinished; here it is only a label.
            continue
        if name in ("AC", "TC", "TO"):
            if current is not None:
                yield current
            current, in_terrain = None, name != "AC"
            if in_terrain:
                yield LeftOut(f"line {line}", f"the terrain {value!r} is no airspace")
                continue
            number += 1
            fault = "" if value else f"line {line}: it has no AC with a class, such as AC D."
            current = _Airspace(number, line, value, fault=fault)
            continue
        try:
            if name == "V":
                key, _, text_of = value.partition("=")
                key, text_of = key.strip().upper(), text_of.strip()
                if key == "X":
                    centre = _place(text_of)
                elif key == "W":
                    width_m = _number(text_of) * _MILE_M
                elif key == "D" and text_of[:1] in ("+", "-"):
                    if current is not None:
                        current.clockwise = text_of[0] == "+"
                elif key != "Z":
                    raise InputError(f"{stated!r} is no variable of OpenAir")
            elif in_terrain:
                continue
            elif current is None:
                unknown.setdefault(f"{name}{_BEFORE}", line)
            elif not _take(current, name, value, centre, width_m):
                unknown.setdefault(name, line)
            elif name == "AY":
                current.kind_line = line
        except InputError as error:
            if current is not None and not current.fault:
                current.fault = f"line {line}: {error}."
    if current is not None:
        yield current


def _take(
    airspace: _Airspace, name: str, value: str, centre: Position | None, width_m: float
) -> bool:
    """Add a record to an airspace; return False for one that is not known."""
    if name == "AN":
        airspace.name = value
    elif name == "AY":
        if airspace.kind.upper() not in ("", value.upper()):
            raise InputError(f"a second AY contradicts {airspace.kind!r}")
        airspace.kind = value
    elif name in ("AL", "AH"):
        if airspace.limits.get(name, value) != value:
            raise InputError(f"a second {name} contradicts {airspace.limits[name]!r}")
        airspace.limits[name] = value
    elif name == "AA":
        airspace.activations.append(value.partition(";")[0].strip())
    elif name == "DP":
        airspace.outline.append(_place(value))
    elif name == "DY":
        airspace.airway.append((_place(value), width_m))
    elif name in ("DA", "DB", "DC"):
        if centre is None:
            raise InputError(f"{name} has no centre before it (V X=)")
        if name == "DC":
            airspace.circles.append((centre, _positive(value) * _MILE_M))
        else:
            airspace.outline.append(_arc(name, value, centre, clockwise=airspace.clockwise))
    elif re.fullmatch("[DV][A-Z]?", name):
        raise InputError(f"the outline has an unknown record {name}")
    else:
        return name in _HARMLESS
    return True


def _arc(name: str, value: str, centre: Position, *, clockwise: bool) -> Arc:
    parts = value.split(",")
    if name == "DA":
        if len(parts) != 3:
            raise InputError(f"DA {value!r} is no radius, start and end")
        radius_m = _positive(parts[0]) * _MILE_M
        start, end = ((_number(part), radius_m) for part in parts[1:])
        return Arc(centre, start, end, clockwise=clockwise)
    # A comma may also occur within the places.
    half = len(parts) // 2
    ends = [bearing(centre, _place(",".join(side))) for side in (parts[:half], parts[half:])]
    if any(radius_m <= 0 for _, radius_m in ends):
        raise InputError("an end of the arc lies at its centre")
    return Arc(centre, *ends, clockwise=clockwise)


def _features(airspace: _Airspace, lines: dict[str, int]) -> Iterator[Read]:
    """Yield the areas of an airspace; ``lines`` keeps the first line of each type and class."""
    try:
        if airspace.fault:
            raise InputError(airspace.fault)
        shapes = list(_shapes(airspace))
        periods = tuple(_periods(airspace))
    except InputError as error:
        yield Bad(airspace.label, str(error))
        return
    limits: dict[str, Limit | None] = {}
    unread = ["AA NONE"] if _is_by_notam(airspace) else []
    for name in ("AL", "AH"):
        stated = airspace.limits.get(name, "")
        try:
            limits[name] = limit_text(stated, "FT", "AMSL") if stated else None
        except ValueError:
            unread.append(f"{name} {stated}")
        if name in airspace.limits and not stated:
            unread.append(name)
    category, airspace_class = airspace.type_and_class
    # The category is the type if there is one, and the class otherwise.
    lines.setdefault(airspace_class, airspace.line)
    lines.setdefault(category, airspace.kind_line if airspace.kind else airspace.line)
    for rings, radius_m, edges in shapes:
        yield Feature(
            airspace.number,
            airspace.name,
            rings,
            radius_m,
            limits.get("AL"),
            limits.get("AH"),
            periods,
            category,
            edges,
            kind="airspace",
            forbids=classes.forbids(category, airspace_class=airspace_class),
            airspace_class=airspace_class,
            unread=tuple(unread),
            remarks=classes.unknown((category, airspace_class), lines),
        )


def _shapes(
    airspace: _Airspace,
) -> Iterator[tuple[tuple[tuple[Position, ...], ...], float | None, Edges]]:
    """Yield rings, radius and edges of each area."""
    for centre, radius_m in airspace.circles:
        yield ((centre,),), radius_m, Edges.DEGREES
    for index, (place, width_m) in enumerate(airspace.airway):
        if width_m <= 0:
            raise InputError("its airway has no width before it (V W=).")
        yield ((place,),), width_m / 2, Edges.DEGREES
        if index:
            rectangle = around(airspace.airway[index - 1][0], place, width_m / 2)
            yield (rectangle,), None, Edges.GEODESIC
    if airspace.outline:
        ring = _ring(airspace.outline)
        if len(ring) < 3:
            raise InputError("its outline has fewer than three corners.")
        yield (ring,), None, Edges.DEGREES
    elif not airspace.circles and not airspace.airway:
        raise InputError(f"it has no outline (line {airspace.line}).")


def _ring(outline: list[_Part]) -> tuple[Position, ...]:
    """Return the corners of an outline, so that no arc cuts off a part of the airspace."""
    inner = _corners(outline, growing=False)
    pairs = zip(inner, (*inner[1:], inner[0]), strict=True)
    is_clockwise = sum(xa * yb - xb * ya for (xa, ya), (xb, yb) in pairs) < 0
    ring = _corners(outline, growing=True, is_clockwise=is_clockwise)
    return tuple(ring[:-1] if len(ring) > 1 and _is_same(ring[0], ring[-1]) else ring)


def _is_same(one: Position, other: Position) -> bool:
    """Return whether two places, such as ends of arcs, are less than a millimetre apart."""
    return math.dist(one, other) < _SAME_DEG


def _corners(outline: list[_Part], *, growing: bool, is_clockwise: bool = True) -> list[Position]:
    """Return the corners; arcs are grown if the airspace lies towards their centre."""
    found: list[Position] = []
    for part in outline:
        if isinstance(part, Arc):
            corners = part.corners(grown=growing and part.clockwise == is_clockwise)
        else:
            corners = [part]
        turn = unwrapped(corners[0], found[-1][0])[0] - corners[0][0] if found else 0.0
        moved = [(lon + turn, lat) for lon, lat in corners] if turn else corners
        found += moved[1:] if found and _is_same(moved[0], found[-1]) else moved
    return found


def _is_by_notam(airspace: _Airspace) -> bool:
    return any(value.upper() == "NONE" for value in airspace.activations)


def _periods(airspace: _Airspace) -> Iterator[Period]:
    """Yield the activation times; an airspace activated by NOTAM counts as always active."""
    if _is_by_notam(airspace):
        return
    for value in airspace.activations:
        start, slash, end = value.partition("/")
        if not slash:
            raise InputError(f"AA {value!r} is no interval START/END.")
        first, last = (
            None if side.strip().upper() == "NONE" else moment(side.strip())
            for side in (start, end)
        )
        period = between(first, last)
        if period.start and period.end and period.end < period.start:
            raise InputError(f"AA {value!r} ends before its start.")
        yield period


def _place(text: str) -> Position:
    """Return a place such as ``60:01:30 N 010:03.5 E`` as longitude and latitude."""
    # Runs of blanks would make the search long, and no place has more characters.
    stated = " ".join(text.split())
    match = _PLACE.fullmatch(stated) if len(stated) <= _MOST_PLACE else None
    if match is None:
        raise InputError(f"{text[:_MOST_PLACE]!r} is no place, such as 60:01:30 N 010:03:00 E")
    parts = match.groups()
    angles = []
    for before, *angle, after in (parts[:5], parts[5:]):
        if bool(before) == bool(after):
            raise InputError(f"{text[:_MOST_PLACE]!r} is no place, such as 60:01:30 N 010:03:00 E")
        degrees, minutes, seconds = _angle(angle)
        if minutes > 60 or seconds > 60:
            raise InputError(f"{text[:_MOST_PLACE]!r} has more than 60 minutes or seconds")
        size = degrees + minutes / 60 + seconds / 3600
        angles.append(-size if (before or after).upper() in "SW" else size)
    latitude, longitude = angles
    if abs(latitude) > 90 or abs(longitude) > 360:
        raise InputError(f"{text[:_MOST_PLACE]!r} is no place on Earth")
    return longitude, latitude


def _angle(parts: Sequence[str | None]) -> tuple[float, float, float]:
    """Return degrees, minutes and seconds, which may be one number such as ``0100300``."""
    first, *rest = parts
    whole, point, decimals = (first or "").partition(".")
    if any(rest) or len(whole) < _WITH_MINUTES:
        degrees, minutes, seconds = (float(part or 0) for part in parts)
        return degrees, minutes, seconds
    if len(whole) < _WITH_SECONDS:
        return float(whole[:-2]), float(whole[-2:] + point + decimals), 0.0
    return float(whole[:-4]), float(whole[-4:-2]), float(whole[-2:] + point + decimals)


def _number(text: str) -> float:
    try:
        return parse(re.sub(r"(?i)\s*nm$", "", text.strip()))
    except ValueError:
        raise InputError(f"{text.strip()!r} is no number") from None


def _positive(text: str) -> float:
    value = _number(text)
    if not 0 < value < 1e4:
        raise InputError(f"{text.strip()!r} is no radius in nautical miles")
    return value
