"""Loading of terrains by name, from files or from arrays, and their description."""

from __future__ import annotations

import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pathgene.host.errors import InputError
from pathgene.host.inputs import exists, require_regular
from pathgene.host.terrain import embedded
from pathgene.host.terrain.grid import Terrain
from pathgene.host.terrain.untrusted import (
    UNREADABLE,
    read_array,
    read_cells,
    read_values,
    require_own_crs,
)
from pathgene.host.terrain.voids import fill


__all__ = ["from_array", "info", "load"]

_KEYS = ("elevation", "dx_m", "dy_m")


def load(
    source: str | Path,
    *,
    cell: tuple[float, float] | None = None,
    fill_voids: bool = False,
    max_cells: int | None = None,
    self_contained: bool = False,
) -> Terrain:
    """Load a terrain.

    Parameters
    ----------
    source : str or Path
        Name of an embedded terrain (:func:`pathgene.host.terrain.names`), or a file: ``.npz`` with
        ``elevation``, ``dx_m``, ``dy_m`` and, if its place on Earth is known, ``crs`` and
        ``origin``; ``.npy`` with the heights (both in metres, row 0 the southernmost); or any other
        file that rasterio opens. A file that has the name of an embedded terrain is given as
        ``./name``.
    cell : tuple of float, optional
        Sides of a cell in metres, east and north, for a file that does not state them.
    fill_voids : bool
        Interpolate the voids, which are otherwise impassable.
    max_cells : int, optional
        Maximum number of cells of a file, 1 or more; 25 million by default.
    self_contained : bool
        Refuse a file that names other files, as a virtual raster does; for content from somebody
        else, such as a browser.

    Raises
    ------
    InputError
        If there is no such terrain, it cannot be read, is not a terrain, has too many cells or
        names a file although that is refused, or ``cell`` is missing, not positive or given for a
        terrain that has its own.
    """
    if not isinstance(source, str | Path):
        raise InputError(f"The terrain must be a name or the path of a file, not {source!r}.")
    if max_cells is not None and max_cells < 1:
        raise InputError(f"A terrain must be allowed 1 cell or more, not {max_cells}.")
    terrain = _load(source, cell, fill_voids, max_cells, self_contained)
    is_file = source not in embedded.names()
    loading = {
        "source": os.path.realpath(source) if is_file else str(source),
        "fill_voids": fill_voids,
        "cell_m": cell and list(cell),
    }
    return replace(terrain, loading=loading)


def _load(
    source: str | Path,
    cell: tuple[float, float] | None,
    fill_voids: bool,
    max_cells: int | None,
    self_contained: bool,
) -> Terrain:
    if cell is not None and not all(math.isfinite(side) and side > 0 for side in cell):
        raise InputError(
            f"The sides of a cell must be positive metres, not {cell[0]:g} x {cell[1]:g}."
        )
    if isinstance(source, str) and source in embedded.names():
        if cell is not None:
            raise InputError(
                f"The terrain {source!r} states the size of its cells; leave it out (--cell)."
            )
        return embedded.load(source)
    path = Path(source)
    if not exists(path):
        raise InputError(
            f"There is no terrain {str(source)!r}: neither a file nor one of "
            f"{', '.join(embedded.names())}."
        )
    if not path.is_dir():  # Some GDAL formats are folders.
        require_regular(path)
    if path.suffix.lower() == ".npz":
        return _load_npz(path, cell, fill_voids, max_cells, self_contained)
    if path.suffix.lower() == ".npy":
        return _load_npy(path, cell, fill_voids, max_cells)
    # They load GDAL, which grids in numpy's formats do not need.
    from pathgene.host.terrain import place, raster

    return place.to_terrain(
        raster.read(path, max_cells, self_contained=self_contained),
        cell=cell,
        fill_voids=fill_voids,
        max_cells=max_cells,
    )


def info(terrain: Terrain) -> dict[str, Any]:
    """Describe a terrain in values that JSON can hold.

    Returns
    -------
    dict
        ``name``, ``shape``, ``dx_m``, ``dy_m``, ``crs``, ``origin``; ``width_m``, ``height_m``;
        ``corners``, latitude and longitude by compass point, or None without a CRS;
        ``elevation_m`` (least, greatest, mean); ``voids`` and ``void_share``; ``source``.
    """
    corners = None
    if terrain.crs is not None and terrain.origin is not None:
        east, north = terrain.width_m, terrain.height_m
        lat, lon = terrain.to_geographic([0.0, east, 0.0, east], [0.0, 0.0, north, north])
        corners = {
            point: [round(float(lat[i]), 9), round(float(lon[i]), 9)]
            for i, point in enumerate(("sw", "se", "nw", "ne"))
        }
    voids = int(terrain.voids.sum())
    return {
        **terrain.describe(),
        "width_m": terrain.width_m,
        "height_m": terrain.height_m,
        "corners": corners,
        "elevation_m": {
            "min": terrain.lowest,
            "max": terrain.highest,
            "mean": float(np.nanmean(terrain.elevation)),
        },
        "voids": voids,
        "void_share": voids / terrain.elevation.size,
        "source": terrain.source,
    }


def _load_npz(
    path: Path,
    cell: tuple[float, float] | None,
    fill_voids: bool,
    max_cells: int | None,
    self_contained: bool,
) -> Terrain:
    if cell is not None:
        raise InputError(f"{path}: the file states the size of its cells; leave it out (--cell).")
    try:
        with ZipFile(path) as file:
            held = {name.removesuffix(".npy") for name in file.namelist()}
            missing = [key for key in _KEYS if key not in held]
            if missing:
                raise InputError(
                    f"{path}: there is no {missing[0]!r} in it; a terrain file holds "
                    f"{', '.join(_KEYS)}."
                )
            elevation = read_cells(path, file, "elevation", max_cells)
            sides = [read_values(file, key) for key in _KEYS[1:]]
            place = [read_values(file, key) if key in held else None for key in ("crs", "origin")]
    except UNREADABLE:
        raise InputError(
            f"{path}: cannot be read as a numpy archive; write it with numpy.savez."
        ) from None
    for key, side in zip(_KEYS[1:], sides, strict=True):
        if side.size != 1 or side.dtype.kind not in "iuf":
            raise InputError(f"{path}: {key!r} must be one number of metres.")
    crs, origin = _place(path, *place, self_contained=self_contained)
    return from_array(
        elevation,
        (sides[0].item(), sides[1].item()),
        name=path.stem,
        source=str(path),
        crs=crs,
        origin=origin,
        fill_voids=fill_voids,
    )


def _place(
    path: Path,
    crs: NDArray[Any] | None,
    origin: NDArray[Any] | None,
    *,
    self_contained: bool,
) -> tuple[str | None, tuple[float, float] | None]:
    """Return the reference system and origin of an ``.npz``; None and None if it has neither."""
    if crs is None and origin is None:
        return None, None
    if (
        crs is None
        or origin is None
        or crs.dtype.kind != "U"
        or crs.size != 1
        or origin.dtype.kind not in "iuf"
        or origin.shape != (2,)
        or not np.isfinite(origin).all()
    ):
        raise InputError(
            f"{path}: 'crs' must be the name of a reference system and 'origin' the easting and "
            "northing of the south-west node in it; write both or neither."
        )
    name = str(crs.item())
    if self_contained:
        require_own_crs(path, name)
    try:
        # Loads GDAL, which a grid without a place does not need.
        from pathgene.host.terrain.geodesy import known_crs

        known_crs(name)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return name, (float(origin[0]), float(origin[1]))


def _load_npy(
    path: Path, cell: tuple[float, float] | None, fill_voids: bool, max_cells: int | None
) -> Terrain:
    if cell is None:
        raise InputError(
            f"{path}: a .npy file does not state the size of its cells; give it in "
            "metres (--cell DX[,DY])."
        )
    try:
        with path.open("rb") as opened:
            elevation = read_array(path, opened, max_cells)
    except UNREADABLE:
        raise InputError(
            f"{path}: cannot be read as a numpy array; write it with numpy.save."
        ) from None
    return from_array(elevation, cell, name=path.stem, source=str(path), fill_voids=fill_voids)


def from_array(
    elevation: ArrayLike,
    cell: tuple[float, float],
    *,
    name: str,
    source: str = "",
    crs: str | None = None,
    origin: tuple[float, float] | None = None,
    fill_voids: bool = False,
) -> Terrain:
    """Return a terrain made from an array.

    Parameters
    ----------
    elevation, name, source, crs, origin
        As for :class:`Terrain`.
    cell : tuple of float
        Sides of a cell in metres, east and north.
    fill_voids : bool
        Interpolate the voids, which are otherwise impassable.

    Raises
    ------
    InputError
        If the heights are not a grid, are all void or are not ground heights, or a side is not
        positive.
    """
    heights = Terrain(source or name, np.asanyarray(elevation), *cell).elevation
    if fill_voids:
        # From the north, like a raster, because the interpolation depends on the direction.
        heights = fill(heights[::-1])[::-1]
    return Terrain(name, heights, *cell, crs, origin, source)
