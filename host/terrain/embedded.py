"""Terrains that come with the package or its libraries."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from importlib import metadata
from typing import NamedTuple

import numpy as np

from pathgene.host.errors import InputError
from pathgene.host.terrain.grid import Terrain


__all__ = ["Entry", "describe", "load", "names"]


class Entry(NamedTuple):
    """A named terrain, as ``pathgene terrain list`` shows it."""

    name: str
    description: str
    source: str
    licence: str


_JACKSBORO = "matplotlib/mpl-data/sample_data/jacksboro_fault_dem.npz"
_PUBLIC_DOMAIN = "public domain"
_OWN = "BSD-2-Clause, as the program"

_ENTRIES = (
    Entry(
        "jacksboro",
        "Cumberland Mountains around Jacksboro, Tennessee, 29 x 31 km",
        "SRTM 3 arc-second (NASA, USGS), the sample jacksboro_fault_dem of matplotlib",
        _PUBLIC_DOMAIN,
    ),
    Entry("canyon", "Winding canyon through a plateau", "synthetic", _OWN),
    Entry("river", "Meandering river between hills", "synthetic", _OWN),
    Entry("large-canyon", "Canyons of 80 x 80 km, up to 3500 m deep", "synthetic", _OWN),
)


def names() -> tuple[str, ...]:
    """Return the names that :func:`load` accepts."""
    return tuple(entry.name for entry in _ENTRIES)


def describe() -> tuple[Entry, ...]:
    """Return the name, description, source and licence of every embedded terrain."""
    return _ENTRIES


@lru_cache(maxsize=8)
def load(name: str) -> Terrain:
    """Return a named terrain.

    Raises
    ------
    InputError
        If there is no terrain of this name.
    """
    try:
        return _MAKERS[name]()
    except KeyError:
        raise InputError(
            f"There is no embedded terrain {name!r}, only {', '.join(names())}."
        ) from None


def _jacksboro() -> Terrain:
    """Return the terrain of matplotlib's sample, (344, 403) int16 pixels of 3 arc-seconds.

    The sample's ``ymin`` is not its southern edge: it was computed from ``ymax``, the northern
    edge, in the wrong direction. Rows run from north to south. With this placement, the highest
    pixel lies on Cross Mountain (36.1983 N, 84.2306 W, 1077 m), and a flat area at 305 m, Norris
    Lake, ends at Norris Dam.
    """
    from affine import Affine
    from rasterio.crs import CRS

    from pathgene.host.terrain import geodesy, place
    from pathgene.host.terrain.raster import Raster

    # Found without importing matplotlib, which takes longer than most commands.
    file = metadata.distribution("matplotlib").locate_file(_JACKSBORO)
    with np.load(str(file)) as sample:
        heights = sample["elevation"].astype(np.float64)
        west, north = float(sample["xmin"]), float(sample["ymax"])
        dx, dy = float(sample["dx"]), float(sample["dy"])
    return place.to_terrain(
        Raster(
            "jacksboro",
            _ENTRIES[0].source,
            heights,
            Affine(dx, 0, west, 0, -dy, north),
            CRS.from_user_input(geodesy.WGS84),
        )
    )


def _synthetic(function: str) -> Callable[[], Terrain]:
    def make() -> Terrain:
        from pathgene.host.terrain import synthetic

        terrain: Terrain = getattr(synthetic, function)(seed=0)
        return terrain

    return make


_MAKERS: dict[str, Callable[[], Terrain]] = {
    "jacksboro": _jacksboro,
    "canyon": _synthetic("canyon"),
    "river": _synthetic("river"),
    "large-canyon": _synthetic("large_canyon"),
}
