"""Loading of terrains by name, from files or from arrays, and their description."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from affine import Affine
from numpy.typing import ArrayLike, NDArray

from pathgene.host.errors import InputError
from pathgene.host.inputs import exists, require_regular
from pathgene.host.remarks import Grade, Reading, Remark
from pathgene.host.terrain import embedded
from pathgene.host.terrain.grid import Terrain
from pathgene.host.terrain.marks import marked, without_marks
from pathgene.host.terrain.reading import complete
from pathgene.host.terrain.stated import HEIGHT_UNITS, NO_WATER, Stated
from pathgene.host.terrain.untrusted import (
    UNREADABLE,
    read_array,
    read_cells,
    read_values,
    require_own_crs,
)
from pathgene.host.terrain.voids import fill, from_corner
from pathgene.host.terrain.water import under_water


__all__ = ["from_array", "info", "load"]

_KEYS = ("elevation", "dx_m", "dy_m")
_UNITS = "metres_per_unit"


def load(
    source: str | Path,
    *,
    cell: tuple[float, float] | None = None,
    fill_voids: bool = False,
    max_cells: int | None = None,
    self_contained: bool = False,
    stated: Stated | None = None,
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
        Refuse a file that names other files, as a virtual raster does: for content that somebody
        else gives, as a browser does.
    stated : Stated, optional
        Unit and reference of heights, and level of the water.

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
    stated = stated or Stated()
    terrain = _load(source, cell, fill_voids, max_cells, self_contained, stated)
    is_file = source not in embedded.names()
    loading = {
        "source": os.path.realpath(source) if is_file else str(source),
        "fill_voids": fill_voids,
        "cell_m": cell and list(cell),
        **stated.to_dict(),
    }
    level = stated.water_level
    if level is None and terrain.reading.facts.get("is_own"):
        level = NO_WATER
    return complete(under_water(terrain.having(loading=loading), level))


def _load(
    source: str | Path,
    cell: tuple[float, float] | None,
    fill_voids: bool,
    max_cells: int | None,
    self_contained: bool,
    stated: Stated,
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
        return _load_npz(path, cell, fill_voids, max_cells, self_contained, stated)
    if path.suffix.lower() == ".npy":
        return _load_npy(path, cell, fill_voids, max_cells, stated)
    # They load GDAL, which grids in numpy's formats do not need.
    from pathgene.host.terrain import place, raster

    return place.to_terrain(
        raster.read(path, max_cells, self_contained=self_contained, stated=stated),
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
        ``elevation_m`` (least, greatest, mean); ``voids`` and ``void_share``; ``source``;
        ``read``, the facts that were read from its file with remarks.
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
        "read": (terrain if terrain.reading.facts else complete(terrain)).reading.to_dict(),
    }


def _load_npz(
    path: Path,
    cell: tuple[float, float] | None,
    fill_voids: bool,
    max_cells: int | None,
    self_contained: bool,
    stated: Stated,
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
            units, datum = (
                read_values(file, key) if key in held else None for key in (_UNITS, "datum")
            )
    except UNREADABLE:
        raise InputError(
            f"{path}: cannot be read as a numpy archive; write it with numpy.savez."
        ) from None
    for key, side in zip(_KEYS[1:], sides, strict=True):
        if side.size != 1 or side.dtype.kind not in "iuf":
            raise InputError(f"{path}: {key!r} must be one number of metres.")
    crs, origin = _place(path, *place, self_contained=self_contained)
    # Only our own files have a raster of zones: their heights are final.
    is_own = "nofly" in held
    made = from_array(
        elevation if is_own else _in_metres(elevation, stated),
        (sides[0].item(), sides[1].item()),
        name=path.stem,
        source=str(path),
        crs=crs,
        origin=origin,
        fill_voids=fill_voids,
        by_gap=not is_own,
    )
    facts = {**made.reading.facts, "is_own": is_own}
    if datum is not None:
        facts["heights"] = {"datum": str(datum.item()), "datum_from": "file"}
    if not is_own:
        facts["heights"] = {**facts.get("heights", {}), **_heights_of(stated)}
    made = made.having(reading=Reading(facts, made.reading.remarks))
    if units is not None:
        return made.having(metres_per_unit=_metres_per_unit(path, units))
    if is_own or crs is None or origin is None:
        return made
    return _measured(made, crs, origin, max_cells)


def _in_metres(elevation: NDArray[Any], stated: Stated) -> NDArray[Any]:
    """Return heights in metres, in the unit that the user states."""
    unit_m = HEIGHT_UNITS[stated.height_unit or "m"]
    return elevation if unit_m == 1.0 or elevation.dtype.kind not in "iuf" else elevation * unit_m


def _heights_of(stated: Stated) -> dict[str, str]:
    """Return the unit and datum of heights that the user states, as facts."""
    facts: dict[str, str] = {}
    if stated.height_unit is not None:
        facts |= {"unit": stated.height_unit, "unit_from": "option"}
    if stated.heights is not None:
        datum = "ellipsoid" if stated.heights == "ellipsoidal" else "mean sea level"
        facts |= {"datum": datum, "datum_from": "option"}
    return facts


def _metres_per_unit(path: Path, units: NDArray[Any]) -> tuple[float, float]:
    if units.shape != (2,) or units.dtype.kind != "f" or not (units > 0).all():
        raise InputError(f"{path}: {_UNITS!r} must be two positive numbers of metres.")
    return float(units[0]), float(units[1])


def _measured(
    made: Terrain, crs: str, origin: tuple[float, float], max_cells: int | None
) -> Terrain:
    """Return the terrain of a file in numpy's format in a frame of true metres, as of a raster."""
    # They load GDAL, which grids without a place do not need.
    from pathgene.host.terrain import geodesy, place, raster

    system, unit_m = geodesy.known_crs(crs), geodesy.unit_m(crs)
    if system.is_geographic:
        raise InputError(
            f"{made.source}: its sides of a cell are metres, but {crs[:40]} has degrees; write it "
            "in a projected reference system."
        )
    dx, dy = made.dx_m / unit_m, made.dy_m / unit_m
    west, north = origin[0] - 0.5 * dx, origin[1] + (made.shape[0] - 0.5) * dy
    return place.to_terrain(
        raster.Raster(
            made.name,
            made.source,
            np.array(made.elevation[::-1]),
            Affine(dx, 0, west, 0, -dy, north),
            system,
            reading=made.reading,
        ),
        max_cells=max_cells,
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
    path: Path,
    cell: tuple[float, float] | None,
    fill_voids: bool,
    max_cells: int | None,
    stated: Stated,
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
    made = from_array(
        _in_metres(elevation, stated),
        cell,
        name=path.stem,
        source=str(path),
        fill_voids=fill_voids,
        by_gap=True,
    )
    facts = {**made.reading.facts, "heights": _heights_of(stated)}
    return made.having(reading=Reading(facts, made.reading.remarks))


def from_array(
    elevation: ArrayLike,
    cell: tuple[float, float],
    *,
    name: str,
    source: str = "",
    crs: str | None = None,
    origin: tuple[float, float] | None = None,
    fill_voids: bool = False,
    by_gap: bool = False,
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
    by_gap : bool
        As for :func:`pathgene.host.terrain.marks.without_marks`.

    Raises
    ------
    InputError
        If the heights are not a grid, are all void or are not ground heights, or a side is not
        positive.
    """
    made = Terrain(source or name, np.asanyarray(elevation), *cell)
    heights, reading = made.elevation, made.reading
    if by_gap:
        heights, marks, warnings = without_marks(
            source or name,
            heights,
            max(cell),
            lambda row, column: from_corner(column * cell[0], row * cell[1]),
            lambda height: "write NaN where there is no height",
        )
        reading = marked(reading, marks).adding(Remark(Grade.WARNING, text) for text in warnings)
    if fill_voids:
        # From the north, like a raster, because the interpolation depends on the direction.
        heights = fill(heights[::-1])[::-1]
    return Terrain(name, heights, *cell, crs, origin, source, reading=reading)
