"""Terrain: heights at the nodes of a grid, and its place on Earth."""

from __future__ import annotations

import contextlib
import copy
import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pathgene.host.errors import InputError
from pathgene.host.files.output import replacing
from pathgene.host.remarks import Reading
from pathgene.host.terrain.file_heights import FileHeights, remedy_of_array
from pathgene.host.terrain.marks import marked, without_marks
from pathgene.host.terrain.voids import UNDECLARED_VOID, from_corner


if TYPE_CHECKING:
    from pathgene.host.terrain.geodesy import LocalFrame
    from pathgene.host.terrain.metric import Metric

__all__ = ["Terrain", "as_heights", "as_sides"]

Floats = NDArray[np.float64]

#: Fields that make the frame, and its size.
_OF_FRAME = {"elevation", "dx_m", "dy_m", "crs", "origin", "metres_per_unit"}
#: Grid north is taken for true north up to this difference.
_NORTH_DEG = 0.1
# Longest side of a map, metres: farther than any place on Earth.
_MOST_M = 1e9


@dataclass(frozen=True, eq=False)
class Terrain:
    """Heights at the nodes of a grid.

    ``elevation[iy, ix]`` is the height at ``(ix * dx_m, iy * dy_m)`` in the local frame: x to the
    east, y to the north, origin at the south-west node.

    Parameters
    ----------
    name : str
        Name in reports.
    elevation : array_like
        ``(ny, nx)`` heights in metres above the datum, row 0 the southernmost, 2 x 2 nodes or more,
        from -11,000 to 9,000 m. A void is NaN, a masked node, -32768, SRTM's mark, or another mark
        (:func:`pathgene.host.terrain.marks.without_marks`). Kept as a read-only float64 copy.
    dx_m, dy_m : float
        Sides of a cell in metres, positive.
    crs : str, optional
        Projected coordinate reference system of the frame, ``EPSG:<code>`` or WKT. None if unknown.
    origin : tuple of float, optional
        Easting and northing of the south-west node in ``crs``, in its units.
    source : str
        Where the heights come from.
    loading : mapping, optional
        Arguments that the terrain was loaded with, as a summary states them: ``source``,
        ``fill_voids``, ``cell_m`` and the given ones of
        :class:`pathgene.host.terrain.stated.Stated`. By default only its source or name.
    metres_per_unit : tuple of float, optional
        Metres on the ground for a unit of ``crs`` east and north; by default the unit's own.
    reading : Reading
        Facts that were read from its file, and remarks on it.
    paper : Terrain, optional
        The terrain as the papers take it: in the metres of its reference system, and without a
        water level. By default the terrain itself.
    accepts_all : bool
        Take all numbers from -11,000 to 9,000 m as heights: the user vouches for them, or they are
        the final heights of a run.

    Raises
    ------
    InputError
        If the heights are not such a grid, are all void or outside this range, or a side is not
        positive.
    """

    name: str
    elevation: Floats
    dx_m: float
    dy_m: float
    crs: str | None = None
    origin: tuple[float, float] | None = None
    source: str = ""
    loading: Mapping[str, Any] = field(default_factory=dict)
    metres_per_unit: tuple[float, float] | None = None
    reading: Reading = field(default_factory=Reading, repr=False)
    paper: Terrain | None = field(default=None, repr=False)
    accepts_all: bool = field(default=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", _as_text(self.name))
        elevation = as_heights(self.name, self.elevation)
        sides = as_sides(self.name, (self.dx_m, self.dy_m), elevation.shape)
        file = FileHeights(
            self.name,
            max(sides),
            lambda row, column: from_corner(column * sides[0], row * sides[1]),
            remedy_of_array,
        )
        elevation, marks = without_marks(
            file, elevation, by_gap=False, accepts_all=self.accepts_all
        )
        if marks and np.isnan(elevation).all():
            raise InputError(f"{self.name}: every node is void; choose a terrain with heights.")
        elevation.setflags(write=False)
        if marks:
            object.__setattr__(self, "reading", marked(self.reading, marks))
        object.__setattr__(self, "elevation", elevation)
        object.__setattr__(self, "dx_m", sides[0])
        object.__setattr__(self, "dy_m", sides[1])
        if not self.loading:
            stated = {"source": self.source or self.name, "fill_voids": False, "cell_m": None}
            object.__setattr__(self, "loading", stated)

    def raised(self, elevation: ArrayLike) -> Terrain:
        """Return the terrain with other heights, metres, such as a surface to fly above.

        They may lie above all ground where a no-fly zone is flown over.

        Parameters
        ----------
        elevation : array_like
            ``(ny, nx)`` heights, as for the terrain.
        """
        heights = as_heights(self.name, elevation)
        heights.setflags(write=False)
        return self.having(elevation=heights)

    def having(self, **values: Any) -> Terrain:
        """Return the terrain with other values, which are neither checked nor copied."""
        changed = copy.copy(self)
        if "name" in values:
            values["name"] = _as_text(values["name"])
        if values.keys() & _OF_FRAME:
            changed.__dict__.pop("metric", None)
        if "elevation" in values:
            for name in ("lowest", "highest"):
                changed.__dict__.pop(name, None)
        for name, value in values.items():
            object.__setattr__(changed, name, value)
        return changed

    def part(self, rows: slice, columns: slice) -> Terrain:
        """Return some rows and columns of the terrain, a copy in a frame of its own.

        It has the north of the whole terrain, and the heights of the papers only if that one has
        them.
        """
        origin = self.origin
        if self.crs is not None and origin is not None:
            east, north = self.frame.metres_per_unit
            origin = (
                origin[0] + columns.start * self.dx_m / east,
                origin[1] + rows.start * self.dy_m / north,
            )
        heights = self.elevation[rows, columns].copy()
        heights.setflags(write=False)
        part = self.having(elevation=heights, origin=origin, paper=None)
        part.__dict__["metric"] = self.metric
        return part

    @property
    def on_paper(self) -> Terrain:
        """The terrain as the papers take it, with its own name and origin."""
        if self.paper is None:
            return self
        return self.paper.having(name=self.name, source=self.source, loading=self.loading)

    @cached_property
    def metric(self) -> Metric | None:
        """Its frame, measured by geodesics; None without a place on Earth."""
        if self.crs is None or self.origin is None:
            return None
        # Loads PROJ.
        from pathgene.host.terrain.metric import measure_frame

        return measure_frame(self.frame, (self.width_m, self.height_m), (self.dx_m, self.dy_m))

    @property
    def north_deg(self) -> float:
        """Direction of the frame's north at the middle, degrees clockwise from true north.

        It is 0 up to a tenth of a degree, and without a place on Earth.
        """
        if self.metric is None:
            return 0.0
        found = self.metric.convergence_at_middle_deg
        return found if abs(found) > _NORTH_DEG else 0.0

    @property
    def shape(self) -> tuple[int, int]:
        """Number of nodes from south to north and from west to east."""
        rows, columns = self.elevation.shape
        return rows, columns

    @property
    def width_m(self) -> float:
        """Metres from the westernmost node to the easternmost."""
        return (self.shape[1] - 1) * self.dx_m

    @property
    def height_m(self) -> float:
        """Metres from the southernmost node to the northernmost."""
        return (self.shape[0] - 1) * self.dy_m

    @property
    def voids(self) -> NDArray[np.bool_]:
        """Nodes without a height, ``(ny, nx)``."""
        return np.isnan(self.elevation)

    @cached_property
    def lowest(self) -> float:
        """Lowest height in metres, ignoring voids."""
        return float(np.nanmin(self.elevation))

    @cached_property
    def highest(self) -> float:
        """Highest height in metres, ignoring voids."""
        return float(np.nanmax(self.elevation))

    def ground(self, x: ArrayLike, y: ArrayLike) -> Any:
        """Return the height of the nearest node, halves rounded up, clamped to the map.

        Parameters
        ----------
        x, y : array_like
            Metres in the local frame; they broadcast.

        Returns
        -------
        float or ndarray
            Metres, NaN over a void; a float for two scalars.
        """
        heights = self.elevation[self.nearest_nodes(x, y)]
        return float(heights) if heights.ndim == 0 else heights

    def nearest_nodes(
        self, x: ArrayLike, y: ArrayLike
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return row and column of the node nearest to each point, halves up, clamped to the map.

        Parameters
        ----------
        x, y : array_like
            Metres in the local frame.
        """
        rows, columns = self.shape
        return _nearest(y, self.dy_m, rows), _nearest(x, self.dx_m, columns)

    def nearest_node(self, x: float, y: float) -> tuple[int, int]:
        """Return row and column of the node nearest to a point, as :meth:`nearest_nodes` does."""
        rows, columns = self.shape
        row, column = (
            math.floor(min(max(at / side + 0.5, 0.0), float(nodes - 1)))
            for at, side, nodes in ((y, self.dy_m, rows), (x, self.dx_m, columns))
        )
        return row, column

    def to_local(self, lat: ArrayLike, lon: ArrayLike) -> tuple[Any, Any]:
        """Convert WGS84 latitude and longitude in degrees to local metres (x, y).

        Warns when the shift between the datums can only be approximated on this machine.

        Raises
        ------
        InputError
            If the terrain has no CRS, or a point cannot be expressed in it.
        """
        frame = self.frame
        lat, lon = np.broadcast_arrays(np.asarray(lat, np.float64), np.asarray(lon, np.float64))
        return _scalars(*frame.from_wgs84(lat, lon))

    def to_geographic(self, x: ArrayLike, y: ArrayLike) -> tuple[Any, Any]:
        """Convert local metres to WGS84 (latitude, longitude) in degrees.

        Warns when the shift between the datums can only be approximated on this machine.

        Raises
        ------
        InputError
            If the terrain has no CRS, or a point has no place on Earth.
        """
        frame = self.frame
        x, y = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(y, np.float64))
        return _scalars(*frame.to_wgs84(x, y))

    def describe(self) -> dict[str, Any]:
        """Return name, shape, cell and place, as in a summary's ``terrain``."""
        return {
            "name": self.name,
            "shape": list(self.shape),
            "dx_m": self.dx_m,
            "dy_m": self.dy_m,
            "crs": self.crs,
            "origin": None if self.origin is None else list(self.origin),
        }

    def save_npz(self, file: str | Path | BinaryIO, nofly: NDArray[np.bool_]) -> None:
        """Write ``elevation``, ``dx_m``, ``dy_m`` and ``nofly`` for ``load``.

        A terrain with a place on Earth adds ``crs``, ``origin`` and ``metres_per_unit``, one with a
        known datum of heights ``datum``.

        Parameters
        ----------
        file : str, Path or binary file
            File to write; its name should end in ``.npz``.
        nofly : ndarray
            ``(ny, nx)`` bool, nodes in a no-fly zone.

        Raises
        ------
        ValueError
            If the shape of ``nofly`` is not the terrain's.
        """
        if nofly.shape != self.shape:
            raise ValueError(
                f"No-fly raster must have the terrain's shape {self.shape}, not {nofly.shape!r}"
            )
        place: dict[str, Any] = {}
        if self.crs is not None and self.origin is not None:
            place = {
                "crs": np.array(self.crs),
                "origin": np.array(self.origin),
                "metres_per_unit": np.array(self.frame.metres_per_unit),
            }
        heights = self.reading.facts.get("heights", {})
        if heights.get("datum_from", "assumed") != "assumed":
            place["datum"] = np.array(heights["datum"])
        # Through a handle: numpy would append its suffix to a name.
        with (
            replacing(Path(file)) if isinstance(file, str | Path) else contextlib.nullcontext(file)
        ) as binary:
            save = np.savez_compressed if _shrinks(self.elevation) else np.savez
            save(
                binary,
                elevation=self.elevation,
                dx_m=self.dx_m,
                dy_m=self.dy_m,
                nofly=nofly.astype(np.bool_),
                **place,
            )

    @property
    def frame(self) -> LocalFrame:
        """The local frame on Earth.

        Raises
        ------
        InputError
            If the terrain has no place on Earth.
        """
        if self.crs is None or self.origin is None:
            raise InputError(
                f"The terrain {self.name!r} has no coordinate reference system, so "
                "latitude and longitude have no meaning on it; give local metres."
            )
        # Loads GDAL, which terrains in local metres do not need.
        from pathgene.host.terrain.geodesy import LocalFrame

        if self.metres_per_unit is None:
            return LocalFrame(self.crs, self.origin)
        return LocalFrame(self.crs, self.origin, self.metres_per_unit)


def as_sides(name: str, cell: tuple[float, float], shape: tuple[int, ...]) -> tuple[float, float]:
    """Return the sides of a cell of a map with ``shape`` nodes, metres.

    Raises
    ------
    InputError
        If one is not positive, or the map longer than :data:`_MOST_M`.
    """
    sides = float(cell[0]), float(cell[1])
    for word, value in zip(("dx_m", "dy_m"), sides, strict=True):
        if not (math.isfinite(value) and value > 0):
            raise InputError(
                f"{name}: the sides of a cell must be positive metres, but {word} is {value:g}."
            )
    for side, nodes in zip(sides, reversed(shape), strict=True):
        length_m = side * (nodes - 1)
        if length_m > _MOST_M:
            raise InputError(
                f"{name}: {nodes} nodes at {side:g} m are a map of {length_m:g} m, and no map may "
                f"be longer than {_MOST_M:g} m; give the sides of a cell in metres."
            )
    return sides


def as_heights(name: str, elevation: ArrayLike) -> Floats:
    """Return numbers as heights, with NaN for voids and for SRTM's mark.

    Raises
    ------
    InputError
        If they are not a grid of 2 x 2 real numbers or more, or are all void.
    """
    raw = np.asarray(elevation)
    if raw.dtype.kind not in "iufb":
        raise InputError(f"{name}: the heights must be real numbers, but are {raw.dtype}.")
    if raw.ndim != 2:
        raise InputError(
            f"{name}: the heights must be a grid of rows and columns, but have "
            f"{raw.ndim} dimensions."
        )
    if min(raw.shape) < 2:
        raise InputError(
            f"{name}: a terrain needs at least 2 x 2 nodes, but this one has "
            f"{raw.shape[0]} x {raw.shape[1]}."
        )
    heights = raw.astype(np.float64)
    void = ~np.isfinite(heights)
    void |= heights == UNDECLARED_VOID
    void |= np.ma.getmask(elevation)
    if void.any():
        heights[void] = np.nan
    if void.all():
        raise InputError(f"{name}: every node is void; choose a terrain with heights.")
    return heights


def _as_text(name: str) -> str:
    """Return a name that files can hold: one of a file may have bytes that are not UTF-8."""
    return name.encode("utf-8", "backslashreplace").decode()


def _nearest(coordinate: ArrayLike, side_m: float, nodes: int) -> NDArray[np.int64]:
    # Clipped before the cast, because a distant point would overflow the integer.
    index = np.floor(np.asarray(coordinate, dtype=np.float64) / side_m + 0.5)
    return np.clip(index, 0, nodes - 1).astype(np.int64)


def _scalars(first: Floats, second: Floats) -> tuple[Any, Any]:
    return (float(first), float(second)) if first.ndim == 0 else (first, second)


def _shrinks(heights: Floats) -> bool:
    """Return whether compression saves a third; it does if heights are whole metres."""
    sample = heights.ravel()[:: max(heights.size // 2_048, 1)].tobytes()
    return len(zlib.compress(sample, 1)) < 2 * len(sample) / 3
