"""Conversion of a raster to a terrain: cells in metres, and the place on Earth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from affine import Affine

from pathgene.host.errors import InputError
from pathgene.host.terrain import geodesy, warp
from pathgene.host.terrain.grid import Terrain
from pathgene.host.terrain.raster import Raster, north_up
from pathgene.host.terrain.voids import fill, from_corner, number, require_heights


__all__ = ["to_terrain"]

# Smallest side of a cell in metres; a map in degrees always has smaller cells.
_SMALLEST_SIDE_M = 0.05


def to_terrain(
    raster: Raster,
    *,
    cell: tuple[float, float] | None = None,
    fill_voids: bool = False,
    max_cells: int | None = None,
) -> Terrain:
    """Convert a raster to a terrain.

    A projected raster keeps its own cells; a geographic one is warped by
    :func:`pathgene.host.terrain.warp.to_utm`. Without a reference system, pixel sizes count as
    metres, or ``cell`` is used if there is no pixel size either.

    Parameters
    ----------
    raster : Raster
        Heights and their place.
    cell : tuple of float, optional
        Sides of a cell in metres, east and north.
    fill_voids : bool
        Interpolate the voids before any reprojection.
    max_cells : int, optional
        As for :func:`pathgene.host.terrain.warp.to_utm`.

    Raises
    ------
    InputError
        If the raster is rotated, all void, smaller than 2 x 2 nodes, too large for one UTM zone,
        has no cell size, or has impossible ground heights; or if ``cell`` is given for a raster
        that has its own.
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
    raster = north_up(raster)
    # Done here, because filling and warping would mix a mark with the ground around it.
    require_heights(
        name,
        raster.heights,
        lambda row, column: _place(raster, row, column),
        lambda height: _remedy(raster, height),
    )
    if fill_voids:
        raster = replace(raster, heights=fill(raster.heights))
    if raster.crs is not None and raster.crs.is_geographic:
        raster = warp.to_utm(raster, max_cells)

    rows, side = len(raster.heights), raster.transform
    if raster.crs is None and min(side.a, -side.e) < _SMALLEST_SIDE_M:
        raise InputError(
            f"{name}: cells of {side.a:g} x {-side.e:g} without a coordinate "
            "reference system look like degrees; add the system to the file."
        )
    crs = None if raster.crs is None else geodesy.crs_name(raster.crs)
    unit_m = 1.0 if crs is None else geodesy.unit_m(crs)
    return Terrain(
        name=name,
        elevation=raster.heights[::-1],
        dx_m=side.a * unit_m,
        dy_m=-side.e * unit_m,
        crs=crs,
        # The south-west node is the centre of the last row's first pixel.
        origin=None if crs is None else (side.c + 0.5 * side.a, side.f + (rows - 0.5) * side.e),
        source=raster.source,
    )


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


def _remedy(raster: Raster, height_m: float) -> str:
    """Return how to declare a file's mark of a void."""
    factor, offset = raster.scaling
    mark = height_m
    if (factor, offset) != (1.0, 0.0):
        # Rounded, because the division may not reproduce the last digits of the file's number.
        mark = float(f"{(height_m - offset) / factor:.12g}")
    return (
        f"declare the mark (gdal_translate -a_nodata {number(mark)} IN.tif OUT.tif), or state the "
        "unit of the heights"
    )
