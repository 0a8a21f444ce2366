"""Reprojection of a raster to a square grid in metres of a frame."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from affine import Affine
from numpy.polynomial import chebyshev
from numpy.typing import NDArray
from rasterio.crs import CRS

from pathgene.host.errors import InputError
from pathgene.host.terrain import geodesy
from pathgene.host.terrain.raster import Raster
from pathgene.host.terrain.untrusted import MAX_CELLS


__all__ = ["largest_rectangle", "to_frame"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# Decimals of a cell's side in metres.
_SIDE_DECIMALS = 2
# Widest geographic raster; in a wider one the frame's metres differ too much from true ones.
_WIDEST_DEG = 12.0
# Near a pole, maximum ratio of a pixel's sides, which multiplies the cells. Pixels of equal degrees
# reach it at 86.4 degrees of latitude.
_LONGEST, _POLAR_DEG = 16.0, 80.0
# Nodes resampled at a time: bounds the memory of a large tile.
_BLOCK_NODES = 1 << 20
# Degrees of the polynomials tried for the inverse projection, and the largest error in pixels.
_DEGREES = (12, 24, 48)
_TOLERANCE_PX = 1e-5
# Rounding of coordinates, in pixels: a node this far outside counts as on the edge.
_ROUNDING_PX = 1e-6


def to_frame(raster: Raster, frame: str, max_cells: int | None = None) -> Raster:
    """Warp a raster to another reference system.

    The cells are square, of the smaller side of the pixel at the centre in metres of the frame,
    rounded to 0.01 m. Heights are interpolated bilinearly between the centres of pixels; in the
    outer half of the outermost pixels the nearest ones are used. A node next to a void, with any
    weight, is a void. The grid is cropped to the largest rectangle inside the raster's edges.

    Parameters
    ----------
    raster : Raster
        North up, at least 2 x 2 pixels.
    frame : str
        Projected reference system in metres: a UTM zone, or a local one.
    max_cells : int, optional
        Maximum number of cells, by default :data:`pathgene.host.terrain.untrusted.MAX_CELLS`. The
        grid may have twice as many, because pixels become narrower towards the poles.

    Returns
    -------
    Raster
        In metres of the frame, north up.

    Raises
    ------
    InputError
        If the raster is wider than 12 degrees, its cells near a pole are too long and narrow, or
        the grid would have too many.
    """
    rows, columns = raster.heights.shape
    side = raster.transform
    west, north = side.c, side.f
    east, south = west + columns * side.a, north + rows * side.e
    if _is_geographic(raster) and max(east - west, north - south) > _WIDEST_DEG:
        raise InputError(
            f"{raster.name}: the raster spans {east - west:g} x {north - south:g} "
            f"degrees, more than the {_WIDEST_DEG:g} that one map can show; cut "
            "out the part you need."
        )
    side_m = _side_m(raster, frame)
    most = 2 * (MAX_CELLS if max_cells is None else max_cells)
    grid = _grid(raster, frame, side_m, most)
    to_pixels = _Inverse(raster, frame, *grid)
    heights, inside = _resample(raster.heights, to_pixels)
    kept_rows, kept_columns = largest_rectangle(inside)
    eastings, northings = grid
    # The corner of the first pixel is half a cell from its centre.
    transform = Affine(
        side_m,
        0,
        eastings[kept_columns.start] - side_m / 2,
        0,
        -side_m,
        northings[kept_rows.start] + side_m / 2,
    )
    return replace(
        raster,
        heights=heights[kept_rows, kept_columns],
        transform=transform,
        crs=CRS.from_user_input(frame),
    )


def largest_rectangle(usable: Bools) -> tuple[slice, slice]:
    """Return rows and columns of the largest rectangle of true cells; ties go to the first found.

    For each row, it is the largest rectangle under the histogram of true cells above, found with a
    stack of rising bars; neighbours of equal height form one bar.
    """
    best, area = (slice(0, 0), slice(0, 0)), 0
    columns = usable.shape[1]
    # A last bar of height 0 empties the stack.
    tall = np.zeros(columns + 1, dtype=np.int64)
    for row, cells in enumerate(usable):
        tall[:-1] = np.where(cells, tall[:-1] + 1, 0)
        changes = np.flatnonzero(np.diff(tall, prepend=-1))
        if changes[-1] != columns:
            changes = np.append(changes, columns)
        stack: list[tuple[int, int]] = []
        for column, height in zip(changes.tolist(), tall[changes].tolist(), strict=True):
            left = column
            while stack and stack[-1][1] >= height:
                left, lower = stack.pop()
                if lower * (column - left) > area:
                    area = lower * (column - left)
                    best = (slice(row + 1 - lower, row + 1), slice(left, column))
            stack.append((left, height))
    return best


class _Inverse:
    """Pixel coordinates of the nodes of a grid in UTM.

    They are smooth in easting and northing, so polynomials through a few exact points are accurate
    to well below a thousandth of a pixel and take a hundredth of the time that PROJ needs.

    Parameters
    ----------
    raster : Raster
        The raster; (0, 0) is the centre of its first pixel.
    frame : str
        Reference system of the nodes.
    eastings, northings : ndarray
        Coordinates of the columns and rows of nodes, metres.
    """

    def __init__(self, raster: Raster, frame: str, eastings: Floats, northings: Floats) -> None:
        self._raster, self._frame = raster, frame
        self._x, self._y = _unit(eastings), _unit(northings)
        self._span = (eastings[0], eastings[-1], northings[0], northings[-1])
        for degree in _DEGREES:
            nodes = np.asarray(chebyshev.chebpts1(degree + 1))
            matrix = np.linalg.inv(chebyshev.chebvander(nodes, degree))
            exact = self._exact(*np.meshgrid(nodes, nodes))
            # [y, x] values to [y, x] coefficients, for column and row.
            self._coefficients = [matrix @ values @ matrix.T for values in exact]
            if self._error_px(degree) <= _TOLERANCE_PX:
                return
        raise InputError(
            f"{raster.name}: the raster is too large to be shown in one map; cut "
            "out the part you need."
        )

    @property
    def shape(self) -> tuple[int, int]:
        """Number of nodes from north to south and from west to east."""
        return len(self._y), len(self._x)

    def rows(self, block: slice) -> tuple[Floats, Floats]:
        """Column and row in pixels of every node of some rows, two ``(n, nx)`` arrays."""
        column, row = (
            self._evaluate(coefficients, self._x, self._y[block])
            for coefficients in self._coefficients
        )
        return column, row

    def _error_px(self, degree: int) -> float:
        """Return the largest error at points between and outside the fitted ones."""
        between = np.concatenate(([-1.0], chebyshev.chebpts1(degree), [1.0]))
        exact = self._exact(*np.meshgrid(between, between))
        return max(
            float(np.abs(self._evaluate(coefficients, between, between) - values).max())
            for coefficients, values in zip(self._coefficients, exact, strict=True)
        )

    @staticmethod
    def _evaluate(coefficients: Floats, x: Floats, y: Floats) -> Floats:
        degree = len(coefficients) - 1
        values: Floats = (
            chebyshev.chebvander(y, degree) @ coefficients @ chebyshev.chebvander(x, degree).T
        )
        return values

    def _exact(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Column and row of points given from -1 to 1 across the grid."""
        first, last, top, bottom = self._span
        lon, lat = geodesy.transform(
            self._frame,
            geodesy.crs_name(self._raster.crs),
            first + (last - first) * (x + 1) / 2,
            top + (bottom - top) * (y + 1) / 2,
        )
        side = self._raster.transform
        if _is_geographic(self._raster):
            # Files may count longitudes beyond 180 degrees; PROJ does not.
            middle = side.c + self._raster.heights.shape[1] * side.a / 2
            lon = middle + (lon - middle + 180.0) % 360.0 - 180.0
        return (lon - side.c) / side.a - 0.5, (lat - side.f) / side.e - 0.5


def _is_geographic(raster: Raster) -> bool:
    return raster.crs is not None and bool(raster.crs.is_geographic)


def _unit(values: Floats) -> Floats:
    """Return evenly spaced ``values`` mapped to -1 to 1."""
    return np.linspace(-1.0, 1.0, len(values))


def _side_m(raster: Raster, frame: str) -> float:
    """Return the smaller side of the pixel at the centre, metres of the frame.

    Raises
    ------
    InputError
        If it is far smaller than the larger side, near a pole, or less than a centimetre.
    """
    rows, columns = raster.heights.shape
    side = raster.transform
    lon, lat = side.c + columns * side.a / 2, side.f + rows * side.e / 2
    east, north = geodesy.transform(
        geodesy.crs_name(raster.crs),
        frame,
        np.array((lon - side.a / 2, lon + side.a / 2, lon, lon)),
        np.array((lat, lat, lat - side.e / 2, lat + side.e / 2)),
    )
    sides = [
        math.hypot(east[last] - east[first], north[last] - north[first])
        for first, last in ((0, 1), (2, 3))
    ]
    side_m = round(min(sides), _SIDE_DECIMALS)
    if side_m <= 0:
        raise InputError(
            f"{raster.name}: its cells are smaller than a centimetre; "
            "check its coordinate reference system."
        )
    ratio = max(sides) / min(sides)
    latitude = float(geodesy.place_points(frame, geodesy.WGS84, east, north)[1][0])
    if ratio > _LONGEST and abs(latitude) > _POLAR_DEG:
        polar = "EPSG:32661" if latitude > 0 else "EPSG:32761"
        raise InputError(
            f"{raster.name}: its cells are {ratio:.0f} times as long as wide, so near the pole; "
            f"warp it to square cells first (gdalwarp -r max -t_srs {polar} IN.tif OUT.tif)."
        )
    return side_m


def _grid(raster: Raster, frame: str, side_m: float, most: int) -> tuple[Floats, Floats]:
    """Eastings, rising, and northings, falling, at most ``most``, that cover the whole raster."""
    rows, columns = raster.heights.shape
    side = raster.transform
    along_x = side.c + side.a * np.linspace(0, columns, min(columns, 64) + 1)
    along_y = side.f + side.e * np.linspace(0, rows, min(rows, 64) + 1)
    lon = np.concatenate(
        (along_x, along_x, np.full_like(along_y, along_x[0]), np.full_like(along_y, along_x[-1]))
    )
    lat = np.concatenate(
        (np.full_like(along_x, along_y[0]), np.full_like(along_x, along_y[-1]), along_y, along_y)
    )
    east, north = geodesy.transform(geodesy.crs_name(raster.crs), frame, lon, lat)
    columns = math.ceil((east.max() - east.min()) / side_m)
    rows = math.ceil((north.max() - north.min()) / side_m)
    if columns * rows > most:
        raise InputError(
            f"{raster.name}: in square cells of the smaller side, {side_m:g} m, it has {rows} x "
            f"{columns}, more than {most:,}; cut it, make it coarser, or allow more (--max-cells)."
        )
    return (
        east.min() + side_m * (np.arange(columns) + 0.5),
        north.max() - side_m * (np.arange(rows) + 0.5),
    )


def _resample(heights: Floats, to_pixels: _Inverse) -> tuple[Floats, Bools]:
    """Return bilinear heights at all nodes, and which nodes lie within the raster's edges."""
    rows, columns = heights.shape
    edge = 0.5 + _ROUNDING_PX
    sampled, inside = np.empty(to_pixels.shape), np.empty(to_pixels.shape, dtype=bool)
    nodes, side = to_pixels.shape
    for start in range(0, nodes, max(1, _BLOCK_NODES // side)):
        block = slice(start, start + max(1, _BLOCK_NODES // side))
        column, row = to_pixels.rows(block)
        inside[block] = (
            (column >= -edge)
            & (column <= columns - 1 + edge)
            & (row >= -edge)
            & (row <= rows - 1 + edge)
        )
        sampled[block] = _bilinear(heights, column, row)
    return sampled, inside


def _bilinear(heights: Floats, column: Floats, row: Floats) -> Floats:
    rows, columns = heights.shape
    column, row = np.clip(column, 0, columns - 1), np.clip(row, 0, rows - 1)
    west = np.minimum(column.astype(np.int64), columns - 2)
    north = np.minimum(row.astype(np.int64), rows - 2)
    right, down = column - west, row - north
    corner, flat = north * columns + west, heights.ravel()
    top = _mix(flat[corner], flat[corner + 1], right)
    bottom = _mix(flat[corner + columns], flat[corner + columns + 1], right)
    return _mix(top, bottom, down)


def _mix(first: Floats, second: Floats, share: Floats) -> Floats:
    # A neighbour without weight has no effect, not even a void.
    mixed = first + share * (second - first)
    np.copyto(mixed, first, where=share == 0)
    np.copyto(mixed, second, where=share == 1)
    return mixed
