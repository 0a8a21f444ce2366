"""Conversion of a raster to a terrain: cells in metres, and the place on Earth."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
from affine import Affine

from pathgene.host.errors import InputError
from pathgene.host.remarks import Grade, Reading, Remark
from pathgene.host.terrain import geodesy, vertical
from pathgene.host.terrain.datum import ELLIPSOID_ACCEPTED, NO_GEOID, ellipsoid_refusal
from pathgene.host.terrain.file_heights import FileHeights, remedy_of_file
from pathgene.host.terrain.frame import Framed, framed
from pathgene.host.terrain.grid import Terrain
from pathgene.host.terrain.marks import marked, without_marks
from pathgene.host.terrain.mixed import require_unmixed
from pathgene.host.terrain.raster import Raster, north_up
from pathgene.host.terrain.suspects import suspicions
from pathgene.host.terrain.voids import fill, from_corner


__all__ = ["to_terrain"]

# Smallest side of a cell in metres; a map in degrees always has smaller cells.
_SMALLEST_SIDE_M = 0.05
# Maximum coordinate of a raster's corners, in metres, degrees or millimetres.
_MOST_UNITS = 1e11
# Points a side at which the geoid is computed; between them it is smooth.
_GEOID_POINTS = 64
# Radius of the Earth, metres.
_EARTH_M = 6_371_000.0


def to_terrain(
    raster: Raster,
    *,
    cell: tuple[float, float] | None = None,
    fill_voids: bool = False,
    max_cells: int | None = None,
) -> Terrain:
    """Convert a raster to a terrain.

    A raster with a reference system is shown in a frame of true metres, with cells of their true
    size: :func:`pathgene.host.terrain.frame.framed`. One without keeps its pixels as metres, or
    takes ``cell`` if it has no pixel size either.

    Parameters
    ----------
    raster : Raster
        Heights and their place.
    cell : tuple of float, optional
        Sides of a cell in metres, east and north.
    fill_voids : bool
        Interpolate the voids before any reprojection.
    max_cells : int, optional
        As for :func:`pathgene.host.terrain.warp.to_frame`.

    Raises
    ------
    InputError
        If the raster is rotated, all void, smaller than 2 x 2 nodes, too large for one map,
        has no cell size, or has heights that are not of the ground; or if ``cell`` is given for a
        raster that has its own.
    """
    name = raster.name
    if np.isnan(raster.heights).all():
        raise InputError(f"{name}: every node is void; choose a terrain with heights.")
    if min(raster.heights.shape) < 2:
        raise InputError(
            f"{name}: a terrain needs at least 2 x 2 nodes, but this one has "
            f"{raster.heights.shape[0]} x {raster.heights.shape[1]}."
        )
    if not raster.transform.is_identity:
        if cell is not None:
            raise InputError(
                f"{name}: the file states the size of its cells; leave it out (--cell)."
            )
    elif cell is None:
        raise InputError(
            f"{name}: the file does not state the size of its cells; give it "
            "in metres (--cell DX[,DY])."
        )
    else:
        raster = replace(raster, transform=Affine(cell[0], 0, 0, 0, -cell[1], 0), crs=None)
    _require_near(raster)
    raster = _known_heights(north_up(raster), fill_voids=fill_voids)
    if raster.crs is None:
        return _off_earth(raster)
    plane = replace(raster, crs=vertical.horizontal(raster.crs))
    _require_no_degrees(plane)
    plane = _above_sea(plane)
    found = framed(plane, max_cells)
    reading = Reading(
        {**plane.reading.facts, "is_warped": found.is_warped},
        (*plane.reading.remarks, *found.remarks),
    )
    terrain = _terrain(replace(found.raster, reading=reading), found.metres_per_unit)
    return terrain.having(paper=_on_paper(plane, found, terrain))


def _require_near(raster: Raster) -> None:
    """Check that all corners of a raster have coordinates that a place on Earth may have.

    Raises
    ------
    InputError
        If one has not: some projections of it never end.
    """
    rows, columns = raster.heights.shape
    side = raster.transform
    farthest = max(
        abs(part)
        for column, row in itertools.product((0, columns), (0, rows))
        for part in (
            side.a * column + side.b * row + side.c,
            side.d * column + side.e * row + side.f,
        )
    )
    if not farthest <= _MOST_UNITS:
        raise InputError(
            f"{raster.name}: the corners of its cells lie up to {farthest:g} from the origin of "
            f"its coordinates, and no place on Earth is beyond {_MOST_UNITS:g}; check the corner "
            "and the sides of cells that the file states."
        )


def _known_heights(raster: Raster, *, fill_voids: bool) -> Raster:
    """Return a raster without marks of voids, and filled if wished."""
    name, (factor, offset) = raster.name, raster.scaling
    is_plain = (factor, offset) == (1.0, 0.0)
    file = FileHeights(
        name,
        _side_m(raster),
        lambda row, column: _place(raster, row, column),
        remedy_of_file,
        # Rounded, because a division may not reproduce the last digits of the file's number.
        float if is_plain else lambda height: float(f"{(height - offset) / factor:.12g}"),
        zero_m=offset,
    )
    # Here, since filling and warping would mix a mark with the ground around it.
    heights, marks = without_marks(file, raster.heights, accepts_all=raster.stated.accepts_all)
    if np.isnan(heights).all():
        raise InputError(f"{name}: every node is void; choose a terrain with heights.")
    reading = marked(raster.reading, marks)
    if raster.vertical is not None and not raster.stated.accepts_all:
        is_unit_known = not is_plain or raster.vertical.unit_from != "assumed"
        require_unmixed(file, heights, reading)
        reading = reading.adding(suspicions(file, heights, is_unit_known=is_unit_known))
    return replace(raster, heights=fill(heights) if fill_voids else heights, reading=reading)


def _require_no_degrees(raster: Raster) -> None:
    """Check that the cells of a projected raster are not degrees that are called metres.

    Raises
    ------
    InputError
        If a side is too short for a cell.
    """
    assert raster.crs is not None
    if not raster.crs.is_projected:
        return
    side = raster.transform
    if min(side.a, -side.e) * geodesy.unit_m(geodesy.crs_name(raster.crs)) < _SMALLEST_SIDE_M:
        raise InputError(
            f"{raster.name}: cells of {side.a:g} x {-side.e:g} look like "
            f"degrees, but {geodesy.its_crs(raster.crs)} is projected; correct it "
            "(gdal_edit -a_srs EPSG:4326 FILE)."
        )


def _off_earth(raster: Raster) -> Terrain:
    """Return the terrain of a raster without a reference system."""
    side = raster.transform
    if min(side.a, -side.e) < _SMALLEST_SIDE_M:
        raise InputError(
            f"{raster.name}: cells of {side.a:g} x {-side.e:g} without a coordinate "
            "reference system look like degrees; add the system to the file."
        )
    return Terrain(
        raster.name, raster.heights[::-1], side.a, -side.e, source=raster.source,
        reading=raster.reading, accepts_all=raster.stated.accepts_all,
    )  # fmt: skip


def _terrain(raster: Raster, metres_per_unit: tuple[float, float]) -> Terrain:
    """Return the terrain of a raster in its frame."""
    assert raster.crs is not None
    rows, side = len(raster.heights), raster.transform
    return Terrain(
        name=raster.name,
        elevation=raster.heights[::-1],
        dx_m=side.a * metres_per_unit[0],
        dy_m=-side.e * metres_per_unit[1],
        crs=geodesy.crs_name(raster.crs),
        # The south-west node is the centre of the last row's first pixel.
        origin=(side.c + 0.5 * side.a, side.f + (rows - 0.5) * side.e),
        source=raster.source,
        metres_per_unit=metres_per_unit,
        reading=raster.reading,
        accepts_all=raster.stated.accepts_all,
    )


def _on_paper(plane: Raster, found: Framed, terrain: Terrain) -> Terrain | None:
    """Return the terrain as the papers take it: in the metres of its reference system."""
    assert plane.crs is not None
    is_own = plane.crs.is_geographic or not found.is_warped
    shown = found.raster if is_own else plane
    unit_m = geodesy.unit_m(geodesy.crs_name(shown.crs))
    if is_own and found.metres_per_unit == (unit_m, unit_m):
        return None
    paper = _terrain(shown, (unit_m, unit_m)).having(metres_per_unit=None)
    return paper.having(elevation=terrain.elevation) if is_own else paper


def _above_sea(raster: Raster) -> Raster:
    """Return a raster with heights above the sea.

    Raises
    ------
    InputError
        If they count from the ellipsoid, the user does not accept that, and PROJ has no geoid.
    """
    if raster.vertical is None or not raster.vertical.is_ellipsoidal:
        return raster
    assert raster.crs is not None
    rows, columns = raster.heights.shape
    across, down = (
        np.linspace(0, count, min(count, _GEOID_POINTS) + 1) for count in (columns, rows)
    )
    side = raster.transform
    x, y = np.meshgrid(side.c + side.a * across, side.f + side.e * down)
    lon, lat = geodesy.place_points(geodesy.crs_name(raster.crs), geodesy.WGS84, x, y)
    geoid = vertical.geoid_heights(lon, lat)
    if geoid is None:
        if raster.vertical.datum_from != "option":
            raise ellipsoid_refusal(raster.name, raster.vertical.stated, NO_GEOID)
        return replace(raster, reading=raster.reading.adding([ELLIPSOID_ACCEPTED]))
    # Along rows, then along columns, at the centres of pixels.
    by_row = np.array([np.interp(np.arange(columns) + 0.5, across, values) for values in geoid])
    low = np.minimum(np.searchsorted(down, np.arange(rows) + 0.5) - 1, len(down) - 2)
    share = ((np.arange(rows) + 0.5 - down[low]) / (down[low + 1] - down[low]))[:, np.newaxis]
    heights = raster.heights - ((1 - share) * by_row[low] + share * by_row[low + 1])
    facts = dict(raster.reading.facts)
    turned = {"datum": "EGM96 geoid", "turned_from": "ellipsoid"}
    facts["heights"] = {**facts.get("heights", {}), **turned}
    note = Remark(
        Grade.NOTE,
        f"Heights above the ellipsoid are turned to heights above the sea by the geoid EGM96, "
        f"{geoid.min():.1f} to {geoid.max():.1f} m.",
    )
    return replace(
        raster, heights=heights, reading=Reading(facts, raster.reading.remarks).adding([note])
    )


def _side_m(raster: Raster) -> float:
    """Return the longer side of a cell in metres, roughly for a geographic raster."""
    longer = max(raster.transform.a, -raster.transform.e)
    if raster.crs is None:
        return longer
    if raster.crs.is_geographic:
        return math.radians(longer) * _EARTH_M
    return longer * geodesy.unit_m(geodesy.crs_name(raster.crs))


def _place(raster: Raster, row: int, column: int) -> str:
    """Return the place of a pixel's centre in words, for a raster with north up."""
    if raster.crs is not None and raster.crs.is_geographic:
        east = raster.transform.c + (column + 0.5) * raster.transform.a
        north = raster.transform.f + (row + 0.5) * raster.transform.e
        return f"at latitude {north:.5f} and longitude {east:.5f}"
    unit_m = 1.0 if raster.crs is None else geodesy.unit_m(geodesy.crs_name(raster.crs))
    east_m = column * raster.transform.a * unit_m
    north_m = (row - len(raster.heights) + 1) * raster.transform.e * unit_m
    return from_corner(east_m, north_m)
