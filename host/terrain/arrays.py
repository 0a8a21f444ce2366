"""Terrains from arrays, and from files in numpy's formats."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
from affine import Affine
from numpy.typing import ArrayLike, NDArray

from pathgene.host.errors import InputError
from pathgene.host.remarks import Reading
from pathgene.host.terrain.datum import (
    ELLIPSOID,
    ELLIPSOID_ACCEPTED,
    Vertical,
    ellipsoid_refusal,
)
from pathgene.host.terrain.file_heights import FileHeights, remedy_of_file
from pathgene.host.terrain.grid import Terrain, as_heights, as_sides
from pathgene.host.terrain.marks import marked, named, without_marks
from pathgene.host.terrain.mixed import require_unmixed
from pathgene.host.terrain.stated import HEIGHT_UNITS, Stated
from pathgene.host.terrain.suspects import suspicions
from pathgene.host.terrain.untrusted import (
    UNREADABLE,
    read_array,
    read_cells,
    read_values,
    require_own_crs,
)
from pathgene.host.terrain.voids import fill, from_corner


__all__ = ["from_array", "load_npy", "load_npz", "require_unstated"]

Floats = NDArray[np.float64]

_KEYS = ("elevation", "dx_m", "dy_m")
_UNITS = "metres_per_unit"
# A metre of UTM differs from a true metre by less than this share.
_LARGE_SHARE = 0.002


def load_npz(
    path: Path,
    *,
    cell: tuple[float, float] | None,
    fill_voids: bool,
    max_cells: int | None,
    self_contained: bool,
    stated: Stated,
) -> Terrain:
    """Load an ``.npz``; the parameters are as for :func:`pathgene.host.terrain.load`."""
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
    lengths = sides[0].item(), sides[1].item()
    stated_datum = None if datum is None else str(datum.item())
    # Only our own files have a raster of zones: their heights are final.
    if "nofly" in held:
        unit = None if units is None else _metres_per_unit(path, units)
        made = _of_run(path, elevation, lengths, fill_voids, stated_datum, stated)
        return made.having(crs=crs, origin=origin, metres_per_unit=unit)
    grid = _Grid(path, elevation, lengths, stated, fill_voids, stated_datum)
    return (
        grid.off_earth() if crs is None or origin is None else grid.on_earth(crs, origin, max_cells)
    )


def require_unstated(subject: str, stated: Stated, *, but: str = "") -> None:
    """Check that no statement on heights is given that would have no effect.

    Parameters
    ----------
    subject : str
        Begin of the sentence: the terrain and its heights.
    but : str
        Name of a statement that is allowed.

    Raises
    ------
    InputError
        If one is given.
    """
    for name in ("height_unit", "heights", "void"):
        if name != but and getattr(stated, name) is not None:
            raise InputError(
                f"{subject}, in metres, with voids marked; leave out --{name.replace('_', '-')}."
            )


def _of_run(
    path: Path,
    elevation: NDArray[Any],
    sides: tuple[float, float],
    fill_voids: bool,
    datum: str | None,
    stated: Stated,
) -> Terrain:
    """Return the grid of a run, whose heights are final."""
    is_accepted = datum == ELLIPSOID and stated.heights == "ellipsoidal"
    require_unstated(
        f"{path}: is the grid of a run with final heights",
        stated,
        but="heights" if is_accepted else "",
    )
    facts: dict[str, Any] = {"is_own": True}
    if datum is not None:
        facts["heights"] = {"datum": datum, "datum_from": "file"}
    if datum == ELLIPSOID and not is_accepted:
        raise ellipsoid_refusal(
            path,
            "datum",
            "as the grid of a run they are final: plan again over heights above the sea",
        )
    made = Terrain(
        str(path),
        elevation,
        *sides,
        reading=Reading(facts, (ELLIPSOID_ACCEPTED,) if is_accepted else ()),
        accepts_all=True,
    ).having(name=path.stem, source=str(path))
    return _filled(made) if fill_voids else made


def _filled(terrain: Terrain) -> Terrain:
    # From the north, like a raster, because the interpolation depends on the direction.
    heights = fill(terrain.elevation[::-1])[::-1]
    heights.setflags(write=False)
    return terrain.having(elevation=heights)


@dataclass(frozen=True)
class _Grid:
    """The numbers of a file in one of numpy's formats that another program wrote."""

    path: Path
    numbers: NDArray[Any]
    sides: tuple[float, float]
    stated: Stated
    fill_voids: bool
    datum: str | None = None

    @property
    def vertical(self) -> Vertical:
        """Unit and datum of the heights: the format's metres, unless the user states a unit."""
        unit, heights = self.stated.height_unit, self.stated.heights
        datum, datum_from = self.datum, "assumed" if self.datum is None else "file"
        if heights is not None:
            datum, datum_from = ELLIPSOID if heights == "ellipsoidal" else None, "option"
        return Vertical(
            unit or "m",
            HEIGHT_UNITS[unit or "m"],
            "assumed" if unit is None else "option",
            datum or "mean sea level",
            datum_from,
            datum == ELLIPSOID,
            "datum",
        )

    def off_earth(self) -> Terrain:
        """Return the terrain without a place on Earth."""
        upright = self.vertical
        numbers, reading = self._checked(upright)
        if upright.is_ellipsoidal:
            if upright.datum_from != "option":
                raise ellipsoid_refusal(
                    self.path,
                    upright.stated,
                    "without a place on Earth they cannot be turned to heights above the sea: "
                    "write crs and origin as well",
                )
            reading = reading.adding([ELLIPSOID_ACCEPTED])
        unit_m = upright.unit_m
        file = FileHeights(
            str(self.path),
            max(self.sides),
            lambda row, column: from_corner(column * self.sides[0], row * self.sides[1]),
            remedy_of_file,
            float if unit_m == 1.0 else lambda height: float(f"{height / unit_m:.12g}"),
        )
        accepts_all = self.stated.accepts_all
        heights = numbers if unit_m == 1.0 else numbers * unit_m
        heights, marks = without_marks(file, heights, accepts_all=accepts_all)
        reading = marked(reading, marks)
        if not accepts_all:
            is_unit_known = upright.unit_from != "assumed"
            require_unmixed(file, heights, reading)
            reading = reading.adding(suspicions(file, heights, is_unit_known=is_unit_known))
        made = Terrain(
            str(self.path), heights, *self.sides, reading=reading, accepts_all=accepts_all
        ).having(name=self.path.stem, source=str(self.path))
        return _filled(made) if self.fill_voids else made

    def on_earth(self, crs: str, origin: tuple[float, float], max_cells: int | None) -> Terrain:
        """Return the terrain in a frame of true metres, as of a raster."""
        # They load GDAL, which grids without a place do not need.
        from pathgene.host.terrain import geodesy, place, raster
        from pathgene.host.terrain.vertical import horizontal, vertical

        system = geodesy.known_crs(crs)
        upright = vertical(self.path, system, "m", self.stated.height_unit, self.stated.heights)
        if self.datum is not None and self.stated.heights is None:
            upright = self.vertical
        if self.stated.height_unit is None:
            upright = replace(upright, unit_from="assumed")
        plane = horizontal(system)
        if plane.is_geographic:
            raise _in_degrees(self.path, crs)
        numbers, reading = self._checked(upright)
        reading = Reading({**reading.facts, "crs": geodesy.crs_name(system)}, reading.remarks)
        unit_m = geodesy.unit_m(geodesy.crs_name(plane))
        dx, dy = (side / unit_m for side in self.sides)
        west, north = origin[0] - 0.5 * dx, origin[1] + (len(numbers) - 0.5) * dy
        return place.to_terrain(
            raster.Raster(
                self.path.stem,
                str(self.path),
                numbers[::-1] * upright.unit_m,
                Affine(dx, 0, west, 0, -dy, north),
                system,
                (upright.unit_m, 0.0),
                upright,
                reading,
                self.stated,
            ),
            fill_voids=self.fill_voids,
            max_cells=max_cells,
        )

    def _checked(self, upright: Vertical) -> tuple[Floats, Reading]:
        """Return the numbers, with NaN for voids, and the facts."""
        numbers = as_heights(str(self.path), self.numbers)
        as_sides(str(self.path), self.sides, numbers.shape)
        reading, voids = named(Reading({"heights": upright.facts}), self.numbers, self.stated)
        return (numbers if voids is None else np.where(voids, np.nan, numbers)), reading


def _metres_per_unit(path: Path, units: NDArray[Any]) -> tuple[float, float]:
    if units.shape != (2,) or units.dtype.kind != "f" or not (units > 0).all():
        raise InputError(f"{path}: {_UNITS!r} must be two positive numbers of metres.")
    return float(units[0]), float(units[1])


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
        from pathgene.host.terrain.geodesy import known_crs, require_earth

        system = known_crs(name)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    require_earth(path, system)
    return name, (float(origin[0]), float(origin[1]))


def load_npy(
    path: Path,
    *,
    cell: tuple[float, float] | None,
    fill_voids: bool,
    max_cells: int | None,
    stated: Stated,
) -> Terrain:
    """Load an ``.npy``; the parameters are as for :func:`pathgene.host.terrain.load`."""
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
    return _Grid(path, elevation, cell, stated, fill_voids).off_earth()


def from_array(
    elevation: ArrayLike,
    cell: tuple[float, float],
    *,
    name: str,
    crs: str | None = None,
    origin: tuple[float, float] | None = None,
    fill_voids: bool = False,
) -> Terrain:
    """Return a terrain made from an array.

    Parameters
    ----------
    elevation, name, crs, origin
        As for :class:`Terrain`.
    cell : tuple of float
        Sides of a cell in metres of the frame, east and north. The terrain has their true size.
    fill_voids : bool
        Interpolate the voids, which are otherwise impassable.

    Raises
    ------
    InputError
        If the heights are not a grid, are all void or are not ground heights, a side is not
        positive, or the metres of the frame are not metres on the ground.
    """
    made = Terrain(name, np.asanyarray(elevation), *cell, crs, origin)
    return _true_sized(_filled(made) if fill_voids else made)


def _in_degrees(name: str | Path, crs: str) -> InputError:
    return InputError(
        f"{name}: its sides of a cell are metres, but {crs[:40]} has degrees; write it in a "
        "projected reference system."
    )


def _true_sized(terrain: Terrain) -> Terrain:
    """Return the terrain with cells of their true size.

    Raises
    ------
    InputError
        If they have no single size, or one that the metres of the frame do not suggest.
    """
    if terrain.crs is None or terrain.origin is None:
        return terrain
    # Loads GDAL, which grids without a place do not need.
    from pathgene.host.terrain.geodesy import known_crs, require_earth

    system = known_crs(terrain.crs)
    require_earth(terrain.name, system)
    if system.is_geographic:
        raise _in_degrees(terrain.name, terrain.crs)
    metric = terrain.metric
    assert metric is not None
    east, north = metric.middle
    cause = ""
    if not metric.is_metric or max(abs(east - 1), abs(north - 1)) > _LARGE_SHARE:
        cause = (
            f"a metre of {terrain.crs} is {east:.4f} m on the ground to the east and {north:.4f} m "
            f"to the north, with differences of {metric.spread:.2%} over the map"
        )
    elif not metric.is_north_up:
        degrees = abs(metric.convergence_at_middle_deg)
        cause = f"north of {terrain.crs} lies {degrees:.0f} degrees off true north"
    if cause:
        raise InputError(
            f"{terrain.name}: {cause}; give an array in a UTM zone, or load the map from a file, "
            "which is warped."
        )
    unit_x, unit_y = terrain.frame.metres_per_unit
    return terrain.having(
        dx_m=terrain.dx_m * east,
        dy_m=terrain.dy_m * north,
        metres_per_unit=(unit_x * east, unit_y * north),
        paper=terrain,
    )
