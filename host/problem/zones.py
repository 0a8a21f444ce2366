"""No-fly zones: circles and polygons, their raster, GeoJSON and form in a summary.

A zone is a cylinder, of infinite height unless it has limits. Source: Roberge and Tarbouchi,
section 3.1; polygons, height limits and times are our additions.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError
from pathgene.host.formats.features import LeftOut, Reference
from pathgene.host.formats.limits import above_ground, height_of
from pathgene.host.formats.shapes import Shape
from pathgene.host.numeric import is_number
from pathgene.host.problem.footprints import Area, Disc, Footprint
from pathgene.host.problem.rings import (
    Ring,
    plain,
    require_near,
    ring_of,
)
from pathgene.host.problem.zone_intake import ZoneOptions, intake
from pathgene.host.remarks import Reading
from pathgene.host.terrain import Terrain


__all__ = [
    "Circle",
    "Polygon",
    "ReadZones",
    "Zone",
    "ZoneOptions",
    "listed",
    "raster",
    "read_zones",
    "zone_from_dict",
]

_DEFAULTS = ZoneOptions()

# The fields of every zone, by their names in a summary and in the properties of GeoJSON.
_COMMON = {"name": "name", "lower": "lower_m", "upper": "upper_m", "t0": "t0_s", "t1": "t1_s"}
# The fields of limits above the ground, which are texts there.
_ABOVE_GROUND = {"lower": "lower_agl_m", "upper": "upper_agl_m"}


@dataclass(frozen=True, kw_only=True, repr=False)
class Zone(ABC):
    """A no-fly zone: a cylinder over a circle or a polygon, optionally limited in height and time.

    The program uses a zone's ``footprint`` and never its class.

    Parameters
    ----------
    name : str
        Name in reports; may be empty.
    lower_m, upper_m : float, optional
        Lowest and highest altitude inside, metres above the terrain's datum; None for no limit.
        ``lower_m`` is below ``upper_m``.
    t0_s, t1_s : float, optional
        The zone is active from ``t0_s`` to ``t1_s`` seconds after the start of the path; None for
        no limit. Not negative, and ``t0_s`` is before ``t1_s``.
    lower_agl_m, upper_agl_m : float, optional
        The same limits in metres above the ground, instead of above the datum. A problem divides
        such a zone into tiles: see :func:`pathgene.host.problem.tiles.over_ground`.
    part_of : Zone, optional
        The zone that this one is a tile of.

    Raises
    ------
    InputError
        If a value is outside the range above.
    """

    name: str = ""
    lower_m: float | None = None
    upper_m: float | None = None
    t0_s: float | None = None
    t1_s: float | None = None
    lower_agl_m: float | None = None
    upper_agl_m: float | None = None
    part_of: Zone | None = field(default=None, compare=False)

    @staticmethod
    def circle(
        x_m: float,
        y_m: float,
        radius_m: float,
        *,
        name: str = "",
        lower_m: float | None = None,
        upper_m: float | None = None,
        t0_s: float | None = None,
        t1_s: float | None = None,
    ) -> Circle:
        """Return the circle around (``x_m``, ``y_m``), metres in the terrain's local frame.

        The remaining parameters are common to all zones; see :class:`Zone`.

        Raises
        ------
        InputError
            If a value is not a finite number, the radius is negative, or a limit is bad.
        """
        return Circle(
            x_m,
            y_m,
            radius_m,
            name=name,
            lower_m=lower_m,
            upper_m=upper_m,
            t0_s=t0_s,
            t1_s=t1_s,
        )

    @staticmethod
    def polygon(
        corners: Sequence[Sequence[float]],
        holes: Sequence[Sequence[Sequence[float]]] = (),
        *,
        name: str = "",
        lower_m: float | None = None,
        upper_m: float | None = None,
        t0_s: float | None = None,
        t1_s: float | None = None,
    ) -> Polygon:
        """Return the polygon with ``corners`` (x, y) in either direction, without its ``holes``.

        The remaining parameters are common to all zones; see :class:`Zone`.

        Raises
        ------
        InputError
            If a ring has fewer than three corners or a coordinate that is not a finite number,
            ``holes`` are not rings, or a limit is bad.
        """
        try:
            rings = [plain(hole) for hole in holes]
        except TypeError:
            raise InputError(f"No-fly polygon: holes must be rings, not {holes!r}.") from None
        return Polygon(
            ring_of(plain(corners)),
            tuple(map(ring_of, rings)),
            name=name,
            lower_m=lower_m,
            upper_m=upper_m,
            t0_s=t0_s,
            t1_s=t1_s,
        )

    @staticmethod
    def read(path: str | Path, terrain: Terrain) -> tuple[Zone, ...]:
        """Read the zones of a file; see :func:`read_zones`."""
        return read_zones(path, terrain).zones

    @property
    @abstractmethod
    def footprint(self) -> Footprint:
        """The zone as seen from above."""

    @abstractmethod
    def moved(self, east_m: float, north_m: float) -> Zone:
        """Return the same zone at a different place."""

    def covers(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return the nodes inside, (ny, nx) bool, of a grid of columns ``x`` and rows ``y``."""
        return self.footprint.covers(x, y)

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """The zone as in ``summary.json``."""

    @property
    def shape(self) -> Shape:
        """The zone in the form of files: a point with the property ``radius_m``, or a polygon."""
        if self.footprint.disc is None:
            return Shape("Polygon", self.footprint.rings, self.limits)
        x_m, y_m, radius_m = self.footprint.disc
        return Shape("Point", (((x_m, y_m),),), {**self.limits, "radius_m": radius_m})

    @property
    def limits(self) -> dict[str, Any]:
        """Name, heights and times that are set: ``name``, ``lower``, ``upper``, ``t0``, ``t1``.

        A limit above the ground is a text, such as ``120 m AGL``.
        """
        values = {key: getattr(self, name) for key, name in _COMMON.items()}
        for key, name in _ABOVE_GROUND.items():
            if (height_m := getattr(self, name)) is not None:
                values[key] = above_ground(height_m)
        return {key: value for key, value in values.items() if value not in (None, "")}

    @property
    def follows_ground(self) -> bool:
        """True if a limit is measured above the ground."""
        return self.lower_agl_m is not None or self.upper_agl_m is not None

    @property
    def whole(self) -> Zone:
        """The zone that this one is a tile of, with its name and times; otherwise the zone."""
        if self.part_of is None:
            return self
        own = {name: getattr(self, name) for name in ("name", "t0_s", "t1_s")}
        if all(getattr(self.part_of, name) == value for name, value in own.items()):
            return self.part_of
        return replace(self.part_of, **own)

    def __repr__(self) -> str:
        # The zone's own fields first, then the common fields that are set.
        own = [each for each in fields(self) if not each.kw_only]
        common = [
            each
            for each in fields(self)
            if each.kw_only and each.compare and getattr(self, each.name) != each.default
        ]
        values = ", ".join(f"{f.name}={getattr(self, f.name)!r}" for f in (*own, *common))
        return f"{type(self).__name__}({values})"

    def _check_limits(self, kind: str) -> None:
        if not isinstance(self.name, str):
            raise InputError(f"No-fly {kind}: name must be a text, not {self.name!r}.")
        for name in (*_COMMON.values(), *_ABOVE_GROUND.values()):
            value = getattr(self, name)
            if value is None or name == "name":
                continue
            if not is_number(value):
                raise InputError(f"No-fly {kind}: {name} must be a finite number, not {value!r}.")
            object.__setattr__(self, name, float(value))
            if name in ("t0_s", "t1_s") and value < 0:
                raise InputError(f"No-fly {kind}: {name} must not be negative, not {value:g}.")
        for key, name in _ABOVE_GROUND.items():
            if getattr(self, name) is not None and getattr(self, _COMMON[key]) is not None:
                raise InputError(f"No-fly {kind}: give {_COMMON[key]} or {name}, not both.")
        for low, high in (
            ("lower_m", "upper_m"),
            ("lower_agl_m", "upper_agl_m"),
            ("t0_s", "t1_s"),
        ):
            first, last = getattr(self, low), getattr(self, high)
            if first is not None and last is not None and not first < last:
                raise InputError(
                    f"No-fly {kind}: {low} must be below {high}, not {first:g} and {last:g}."
                )


@dataclass(frozen=True, repr=False)
class Circle(Zone):
    """A circular zone around (``x_m``, ``y_m``), local metres.

    A node is in the zone if its distance to the axis is at most ``radius_m``, which is 0 or more.

    Raises
    ------
    InputError
        If a value is not a finite number, or the radius is negative.
    """

    x_m: float
    y_m: float
    radius_m: float

    def __post_init__(self) -> None:
        for name in ("x_m", "y_m", "radius_m"):
            value = getattr(self, name)
            if not is_number(value):
                raise InputError(f"No-fly circle: {name} must be a finite number, not {value!r}.")
            object.__setattr__(self, name, float(value))
        require_near("circle", (self.x_m, self.y_m, self.radius_m))
        if self.radius_m < 0:
            raise InputError(
                f"No-fly circle: radius_m must not be negative, not {self.radius_m:g}."
            )
        self._check_limits("circle")

    @property
    def footprint(self) -> Disc:
        """The zone as seen from above."""
        return Disc(self.x_m, self.y_m, self.radius_m)

    def moved(self, east_m: float, north_m: float) -> Circle:
        """Return the same circle at a different place."""
        return replace(self, x_m=self.x_m + east_m, y_m=self.y_m + north_m)

    def to_dict(self) -> dict[str, Any]:
        """The zone as in ``summary.json``."""
        return {"x": self.x_m, "y": self.y_m, "radius_m": self.radius_m, **self.limits}


@dataclass(frozen=True, repr=False)
class Polygon(Zone):
    """A polygonal zone, local metres.

    A node is in the zone if it lies inside ``ring`` and not inside a hole, or within a micrometre
    of an edge of either. If a ring crosses itself, the even-odd rule applies.

    Parameters
    ----------
    ring : tuple of (x, y)
        At least three corners in either direction; a closing corner equal to the first is dropped.
    holes : tuple of rings
        Parts left out, inside ``ring``.

    Raises
    ------
    InputError
        If a ring has fewer than three corners or a coordinate that is not a finite number.
    """

    ring: Ring
    holes: tuple[Ring, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "ring", ring_of(self.ring))
        object.__setattr__(self, "holes", tuple(ring_of(hole) for hole in self.holes))
        self._check_limits("polygon")

    @property
    def footprint(self) -> Area:
        """The zone as seen from above."""
        return Area((self.ring, *self.holes))

    def moved(self, east_m: float, north_m: float) -> Polygon:
        """Return the same polygon at a different place."""
        ring, *holes = (
            tuple((x + east_m, y + north_m) for x, y in each) for each in self.footprint.rings
        )
        return replace(self, ring=ring, holes=tuple(holes))

    def to_dict(self) -> dict[str, Any]:
        """The zone as in ``summary.json``; it has ``holes`` only if there are any."""
        table: dict[str, Any] = {"polygon": [list(corner) for corner in self.ring]}
        if self.holes:
            table["holes"] = [[list(corner) for corner in hole] for hole in self.holes]
        return {**table, **self.limits}


def listed(zones: Iterable[Zone]) -> tuple[Zone, ...]:
    """Return zones that a user lists as a tuple.

    Raises
    ------
    InputError
        If they are not a list, or one is not a zone.
    """
    given = tuple(zones) if isinstance(zones, Iterable) else (None,)
    if not all(isinstance(zone, Zone) for zone in given):
        raise InputError(f"The zones must be a list of no-fly zones, not {zones!r}.")
    return tuple(zone for zone in given if isinstance(zone, Zone))


def raster(zones: Iterable[Zone], terrain: Terrain) -> NDArray[np.bool_]:
    """Return the nodes of ``terrain`` in a zone, (ny, nx) bool, row 0 the southernmost."""
    rows, columns = terrain.elevation.shape
    x: NDArray[np.float64] = np.arange(columns, dtype=np.float64) * terrain.dx_m
    y: NDArray[np.float64] = np.arange(rows, dtype=np.float64) * terrain.dy_m
    inside = np.zeros((rows, columns), dtype=bool)
    for zone in zones:
        inside |= zone.covers(x, y)
    return inside


def zone_from_dict(table: Any) -> Zone:
    """Make a zone from its form in ``summary.json``.

    Raises
    ------
    InputError
        If it describes neither a circle nor a polygon, or its values are bad.
    """
    if isinstance(table, dict):
        common = _common(table)
        own = set(table) - set(_COMMON)
        if own == {"x", "y", "radius_m"}:
            return Circle(table["x"], table["y"], table["radius_m"], **common)
        if "polygon" in own and own <= {"polygon", "holes"}:
            holes = table.get("holes", [])
            if isinstance(holes, list):
                return Polygon(table["polygon"], tuple(holes), **common)
    raise InputError(
        'A no-fly zone must be {"x", "y", "radius_m"} or {"polygon": [[x, y], ...]}, '
        f"not {table!r}."
    )


def _common(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of every zone from a table or from properties of a shape."""
    common = {name: table[key] for key, name in _COMMON.items() if table.get(key) is not None}
    for key, name in _ABOVE_GROUND.items():
        if not isinstance(table.get(key), str):
            continue
        stated = height_of(table[key], f"{key} limit of a no-fly zone")
        del common[_COMMON[key]]
        if stated.reference is Reference.AMSL:
            common[_COMMON[key]] = stated.height_m
        elif key == "upper" or stated.height_m > 0:
            # A lower limit at the ground is none: the zone reaches below it.
            common[name] = stated.height_m
    return common


@dataclass(frozen=True)
class ReadZones:
    """Zones of files.

    Parameters
    ----------
    zones : tuple of Zone
        The zones near the map.
    left_out : tuple of LeftOut
        Parts of the files that are not zones.
    reading : Reading
        The report on them.
    """

    zones: tuple[Zone, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    reading: Reading = field(default_factory=Reading)


def read_zones(path: str | Path, terrain: Terrain, options: ZoneOptions = _DEFAULTS) -> ReadZones:
    """Read zones from a file of a format that :data:`pathgene.host.formats.registry.FORMATS` has.

    Positions in degrees are moved into the terrain's frame. A feature may have limits of height and
    times; see docs/files.md for each format.

    Raises
    ------
    InputError
        If the file cannot be read or has a bad feature that ``options`` do not skip, or has
        geographic coordinates although the terrain has no coordinate reference system.
    """
    taken = intake(path, terrain, options, _zone)
    return ReadZones(tuple(taken.zones), tuple(taken.left_out), taken.reading)


def _zone(shape: Shape) -> Zone:
    common = _common(shape.properties)
    if shape.kind == "Point":
        ((x, y),) = shape.rings[0]
        return Circle(x, y, shape.properties["radius_m"], **common)
    ring, *holes = shape.rings
    return Polygon(ring, tuple(holes), **common)
