"""Loading of terrains by name or from files, and their description."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from pathgene.host.errors import InputError
from pathgene.host.inputs import exists, require_regular
from pathgene.host.suggestion import did_you_mean
from pathgene.host.terrain import arrays, embedded
from pathgene.host.terrain.grid import Terrain
from pathgene.host.terrain.reading import complete
from pathgene.host.terrain.stated import NO_WATER, Stated
from pathgene.host.terrain.water import under_water


__all__ = ["info", "load"]


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
        Unit and reference of heights, marks of voids, and level of the water.

    Raises
    ------
    InputError
        If there is no such terrain, it cannot be read, is not a terrain, has too many cells or
        names a file although that is refused; ``cell`` is missing, not positive or given for a
        terrain that has its own; or ``stated`` has no effect on it.
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
        arrays.require_unstated(f"The terrain {source!r} has heights above the sea", stated)
        return embedded.load(source)
    path = Path(source)
    if not exists(path):
        raise InputError(
            f"There is no terrain {str(source)!r}{did_you_mean(str(source), embedded.names())}: "
            f"neither a file nor one of {', '.join(embedded.names())}."
        )
    if not path.is_dir():  # Some GDAL formats are folders.
        require_regular(path)
    if path.suffix.lower() == ".npz":
        return arrays.load_npz(
            path,
            cell=cell,
            fill_voids=fill_voids,
            max_cells=max_cells,
            self_contained=self_contained,
            stated=stated,
        )
    if path.suffix.lower() == ".npy":
        return arrays.load_npy(
            path, cell=cell, fill_voids=fill_voids, max_cells=max_cells, stated=stated
        )
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
