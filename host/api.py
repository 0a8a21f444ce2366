"""Parts of the Python API whose form differs from the host's; :mod:`pathgene` exports them.

Importing this module is quick: numba and SciPy are imported when a path is evaluated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from numpy.typing import ArrayLike

from pathgene.host.errors import InputError
from pathgene.host.numeric import real
from pathgene.host.planners import PLANNERS, Entry
from pathgene.host.terrain.arrays import from_array
from pathgene.host.terrain.grid import Terrain as HostTerrain
from pathgene.host.terrain.load import load
from pathgene.host.terrain.reading import complete
from pathgene.host.terrain.stated import Stated


if TYPE_CHECKING:
    from pathgene.host.evaluation import Evaluation
    from pathgene.host.problem.problem import Problem

__all__ = ["Terrain", "check", "planners"]


class Terrain(HostTerrain):
    """Heights at the nodes of a grid; made by :meth:`load` or :meth:`from_array`.

    ``elevation[iy, ix]`` is the height in metres at ``(ix * dx_m, iy * dy_m)`` of the local frame:
    x to the east, y to the north, origin at the south-west node. NaN is a void.
    """

    @classmethod
    def load(
        cls,
        source: str | Path,
        *,
        cell_m: float | Sequence[float] | None = None,
        fill_voids: bool = False,
        max_cells: int | None = None,
        water_level: float | str | None = None,
        height_unit: str | None = None,
        heights: str | None = None,
        void: float | Sequence[float] | str | None = None,
    ) -> Self:
        """Load a terrain by name or from a file.

        Cells have their true size. A geographic raster, and a projected one whose metres are not
        true metres, is warped. ``reading`` says what was read.

        Parameters
        ----------
        source : str or Path
            ``"jacksboro"``, ``"canyon"``, ``"river"`` or ``"large-canyon"``, which come with the
            package; a GeoTIFF, an SRTM ``.hgt`` or any other file that rasterio opens; an ``.npz``
            with ``elevation``, ``dx_m``, ``dy_m`` and, optionally, ``crs`` and ``origin``; or an
            ``.npy`` with the heights (in both, row 0 is the southernmost).
        cell_m : float or (float, float), optional
            Side of a cell in metres, or its sides to the east and to the north; for an ``.npy``.
        fill_voids : bool
            Interpolate the voids, which no path may cross otherwise.
        max_cells : int, optional
            Maximum number of cells of a file, 1 or more; 25 million by default.
        water_level : float or "none", optional
            Height of the water above the datum, metres: lower ground is the bottom of the sea. By
            default 0 on Earth; ``"none"`` is for land below the sea.
        height_unit : "m", "dm", "cm", "ft" or "us-ft", optional
            Unit of the heights in the file; by default as the file states, or metres.
        heights : "sea-level" or "ellipsoidal", optional
            Reference of the heights in the file; by default as the file states.
        void : float, sequence of float or "none", optional
            Numbers of the file that mark voids, in addition to the declared one. ``"none"`` takes
            all numbers from -11,000 to 9,000 m as heights; by default, numbers that no ground has
            are voids or refused.

        Raises
        ------
        InputError
            If there is no such terrain, it cannot be read, is not a terrain or has more cells, or
            ``cell_m`` is missing, not positive or given for a file that states its own.
        """
        cell = None if cell_m is None else _sides(cell_m)
        stated = Stated(height_unit, heights, water_level, void)
        return cls._of(
            load(source, cell=cell, fill_voids=fill_voids, max_cells=max_cells, stated=stated)
        )

    @classmethod
    def from_array(
        cls,
        elevation: ArrayLike,
        cell_m: float | Sequence[float],
        *,
        name: str = "terrain",
        crs: str | None = None,
        origin: tuple[float, float] | None = None,
        fill_voids: bool = False,
    ) -> Self:
        """Make a terrain from an array of heights.

        Parameters
        ----------
        elevation : array_like
            Heights in metres, (ny, nx), row 0 the **southernmost**, 2 x 2 or more; NaN is a void.
        cell_m : float or (float, float)
            Side of a cell in metres, or its sides to the east and to the north; with ``crs``, in
            metres of the system. The terrain has their true size.
        name : str
            Name in summaries and pictures.
        crs : str, optional
            Projected coordinate reference system of the local frame, ``"EPSG:32616"`` for example.
            Needed for latitudes and longitudes.
        origin : (float, float), optional
            Easting and northing of the south-west node in ``crs``, in its units.
        fill_voids : bool
            Interpolate the voids, which no path may cross otherwise.

        Raises
        ------
        InputError
            If the heights are not a grid of real numbers, are all void, a side is not positive,
            ``crs`` or ``origin`` has the wrong type, or metres of ``crs`` differ from true ones by
            more than 0.2 %, or by more than 0.05 % over the map.
        """
        if not isinstance(crs, str | None):
            raise InputError(f"The crs must be the name of a reference system, not {crs!r}.")
        made = from_array(
            elevation,
            _sides(cell_m),
            name=name,
            crs=crs,
            origin=None if origin is None else _pair("origin", origin),
            fill_voids=fill_voids,
        )
        return cls._of(complete(made))

    @classmethod
    def _of(cls, terrain: HostTerrain) -> Self:
        return cls(**{field.name: getattr(terrain, field.name) for field in fields(terrain)})


def _sides(cell_m: float | Sequence[float]) -> tuple[float, float]:
    """Return the east and north sides of a cell that a user gives as one number or two."""
    sides: Any = (cell_m, cell_m) if isinstance(cell_m, Real) else cell_m
    try:
        east, north = (real("side of a cell", side) for side in sides)
    except (TypeError, ValueError, InputError):
        raise InputError(
            f"The size of a cell must be one number of metres or two, not {cell_m!r}."
        ) from None
    return east, north


def _pair(name: str, value: Any) -> tuple[float, float]:
    try:
        first, second = (real(name, each) for each in value)
    except (TypeError, ValueError, InputError):
        raise InputError(f"The {name} must be two numbers, not {value!r}.") from None
    return first, second


def check(problem: Problem, path: ArrayLike) -> Evaluation:
    """Evaluate a given path.

    Parameters
    ----------
    problem : Problem
        Terrain, ends, aircraft, zones and wind.
    path : array_like
        Waypoints, (n, 3) metres, from the start to the goal of the problem, both included.

    Returns
    -------
    Evaluation
        Feasibility, fitness and every term of them.

    Raises
    ------
    InputError
        If the path is not an array of real numbers, has the wrong shape, does not have the
        problem's start and goal as its ends, or a coordinate is not finite or too large.
    """
    from pathgene.host.checking import check

    return check(problem, path).evaluation


def planners() -> dict[str, Entry]:
    """Return the planners by name, the default first.

    Each entry has a ``description``, the ``paper`` it comes from, the maximum number of
    ``generations`` by default, the names of its own ``options``, and the ``engines`` it can run on.
    """
    return dict(PLANNERS)
