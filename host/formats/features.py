"""Features of zone files: shapes in degrees, with the limits that the file states.

A reader of a format turns its file into features and knows no terrain. It yields, in the order of
the file, a :class:`Feature` for each area, a :class:`LeftOut` for each part that is not an area,
and a :class:`Bad` for each part that is broken. It raises InputError only if no part of the file
can be read. :mod:`pathgene.host.problem.placing` turns features into zones of a terrain.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime, time
from enum import StrEnum

from pathgene.host.remarks import Remark


__all__ = [
    "Bad",
    "Edges",
    "Feature",
    "LeftOut",
    "Limit",
    "Period",
    "Position",
    "Read",
    "Reference",
    "SunEvent",
    "label",
]

#: WGS84 longitude and latitude, degrees; a longitude may lie beyond 180.
Position = tuple[float, float]


class Reference(StrEnum):
    """Surface from which a height limit is measured."""

    AMSL = "AMSL"
    AGL = "AGL"
    WGS84 = "WGS84"
    STANDARD = "STD"


class Edges(StrEnum):
    """Line between two corners."""

    #: Straight in longitude and latitude, as ground stations draw it.
    DEGREES = "degrees"
    GEODESIC = "geodesic"
    RHUMB = "rhumb"
    #: Straight in the terrain's frame, in files that pathgene wrote over this terrain.
    FRAME = "frame"


class SunEvent(StrEnum):
    """Bounds of a daily period that follow the sun."""

    MORNING_TWILIGHT = "BMCT"
    SUNRISE = "SR"
    SUNSET = "SS"
    EVENING_TWILIGHT = "EECT"


@dataclass(frozen=True)
class Limit:
    """Lower or upper limit of a zone.

    Parameters
    ----------
    height_m : float
        Metres above the reference; of a flight level, in the standard atmosphere.
    reference : Reference
        Surface that the height is measured from.
    text : str
        The limit as the file states it, such as ``FL 95``; empty for metres.
    """

    height_m: float
    reference: Reference
    # Limits are equal even if they are stated differently.
    text: str = field(default="", compare=False)

    @property
    def described(self) -> str:
        """The limit in words."""
        return self.text or f"{self.height_m:g} m {self.reference}"


@dataclass(frozen=True)
class Period:
    """Time in which a zone is active.

    Parameters
    ----------
    start, end : datetime, optional
        First and last moment, with a time zone; None for no limit.
    days : frozenset of int
        Days of the week, Monday is 0; empty for every day.
    first, last : time or SunEvent, optional
        Bounds in each day, UTC; None for the whole day. ``last`` may lie before ``first``: the
        period then ends on the following day.
    has_plain_times : bool
        A time or moment of the file has no time zone, and counts as UTC.
    """

    start: datetime | None = None
    end: datetime | None = None
    days: frozenset[int] = frozenset()
    first: time | SunEvent | None = None
    last: time | SunEvent | None = None
    # Periods are equal even if they are stated differently.
    has_plain_times: bool = field(default=False, compare=False)


@dataclass(frozen=True)
class Feature:
    """An area of a file, which may forbid flight.

    Parameters
    ----------
    number : int
        Place in the file, from 1.
    name : str
        Name in the file; empty for none.
    rings : tuple of rings
        Outer ring and holes, corners in degrees without the closing corner; one ring of one
        position for a circle.
    radius_m : float, optional
        Radius of a circle; None for a polygon.
    lower, upper : Limit, optional
        Limits of height; None for no limit.
    periods : tuple of Period
        Times in which the zone is active; empty for always.
    category : str
        Class of airspace or restriction as the file states it, such as ``PROHIBITED`` or ``CTR``;
        empty for none.
    edges : Edges
        Line between two corners.
    t0_s, t1_s : float, optional
        Seconds after the start of the path, for files that state these instead of periods.
    kind : str
        Word for a part of the file in sentences, such as ``feature`` or ``placemark``.
    forbids : bool
        False for an area that informs only, such as a class of airspace that is open to flight.
    keeps_in : bool
        True for an inclusion fence: the zone is all of the map outside the area.
    is_local : bool
        True for positions in metres of the terrain's frame instead of degrees.
    unread : tuple of str
        Names of properties that may limit the area and are not read.
    valid : Period, optional
        Time in which the whole file is valid, as it states; it limits no zone.
    remarks : tuple of Remark
        Clauses about the area, such as ``its heights contradict each other``; the report adds the
        names of the file and the area.
    airspace_class : str
        Class of airspace beside a category that is a type, such as ``D``; empty for none. The area
        forbids if either forbids.
    """

    number: int
    name: str
    rings: tuple[tuple[Position, ...], ...]
    radius_m: float | None = None
    lower: Limit | None = None
    upper: Limit | None = None
    periods: tuple[Period, ...] = ()
    category: str = ""
    edges: Edges = Edges.DEGREES
    t0_s: float | None = None
    t1_s: float | None = None
    kind: str = "feature"
    forbids: bool = True
    keeps_in: bool = False
    is_local: bool = False
    unread: tuple[str, ...] = ()
    valid: Period | None = None
    remarks: tuple[Remark, ...] = ()
    airspace_class: str = ""

    @property
    def label(self) -> str:
        """Number and name in the file."""
        return label(self.kind, self.number, self.name)


@dataclass(frozen=True)
class Bad:
    """A broken part of a file: the file is refused or, on demand, read without it.

    Parameters
    ----------
    label : str
        Number and name in the file, such as ``feature 17, "R-7"``.
    reason : str
        One sentence on the fault, with a full stop.
    """

    label: str
    reason: str


@dataclass(frozen=True)
class LeftOut:
    """A part of a file that is not a zone.

    Parameters
    ----------
    label : str
        Number and name in the file, such as ``feature 17, "R-7"``.
    reason : str
        Reason in words, such as ``a line is not an area``.
    is_suspicious : bool
        The part may forbid flight, such as a link to more zones; the report warns about it.
    """

    label: str
    reason: str
    is_suspicious: bool = False


#: A part of a file, as a reader yields it.
Read = Feature | LeftOut | Bad


def label(kind: str, number: int, name: str = "") -> str:
    """Return number and name of a part of a file, such as ``feature 17, "R-7"``."""
    return f'{kind} {number}, "{name}"' if name else f"{kind} {number}"
