"""Raster files: heights, voids, units and orientation."""

from __future__ import annotations

import contextlib
import math
import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import rasterio
from affine import Affine
from numpy.typing import NDArray
from rasterio.crs import CRS
from rasterio.errors import NotGeoreferencedWarning, RasterioError
from rasterio.io import DatasetReader

from pathgene.host.errors import InputError
from pathgene.host.inputs import exists, require_regular
from pathgene.host.remarks import Reading
from pathgene.host.terrain import geodesy, vrt
from pathgene.host.terrain.contents import doubts, require_heights
from pathgene.host.terrain.datum import Vertical
from pathgene.host.terrain.marks import Mark, marked, named
from pathgene.host.terrain.stated import Stated
from pathgene.host.terrain.unreadable import kind_of_content, why_unreadable
from pathgene.host.terrain.untrusted import (
    MAX_CELLS,
    SELF_CONTAINED,
    require_cells,
    require_own_crs,
)
from pathgene.host.terrain.vertical import horizontal, vertical
from pathgene.host.terrain.voids import UNDECLARED_VOID


__all__ = ["Raster", "north_up", "read"]

Floats = NDArray[np.float64]

# Names of tags for the unit of heights: not for the unit of a resolution or of an axis.
_UNIT_TAG = re.compile(
    r"((band_?1|z|heights?|elevation|vertical|data|value)[ _#]*)?units?([ _]?(type|name))?",
    re.IGNORECASE,
)
# Virtual rasters that are made of one another.
_MOST_DEPTH = 50


@dataclass(frozen=True)
class Raster:
    """The heights of a file.

    Parameters
    ----------
    name, source : str
        Name and origin of the terrain.
    heights : ndarray
        ``(rows, columns)`` float64 metres, in the order of the file; NaN is a void.
    transform : Affine
        From column and row of a pixel's corner to coordinates in ``crs``.
    crs : CRS or None
        Reference system, if the file names one.
    scaling : tuple of float
        Factor and offset that turn the numbers of the file into metres.
    vertical : Vertical, optional
        Unit and datum of the heights; None in files written by pathgene.
    reading : Reading
        Facts that were read, and remarks.
    stated : Stated
        Statements of the user on the heights.
    """

    name: str
    source: str
    heights: Floats
    transform: Affine
    crs: CRS | None
    scaling: tuple[float, float] = (1.0, 0.0)
    vertical: Vertical | None = None
    reading: Reading = field(default_factory=Reading)
    stated: Stated = field(default_factory=Stated)


def read(
    path: Path,
    max_cells: int | None = None,
    *,
    self_contained: bool = False,
    stated: Stated | None = None,
) -> Raster:
    """Read the heights of a file that rasterio opens.

    Parameters
    ----------
    path : Path
    max_cells, self_contained
        As for :func:`pathgene.host.terrain.load`.
    stated : Stated, optional
        Statements of the user on the heights.

    Raises
    ------
    InputError
        If it cannot be read, has several bands, complex data, too many cells, heights in an
        unknown unit or no heights, or if it must be self-contained and is not.
    """
    stated = stated or Stated()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            most = max(MAX_CELLS, max_cells or 0)
            with contextlib.ExitStack() as stack:
                if self_contained:
                    file = stack.enter_context(_opened_alone(path))
                    _require_blocks(path, file, most)
                else:
                    _require_readable(path, most, {path})
                    file = stack.enter_context(rasterio.open(path))
                if file.count != 1:
                    raise InputError(
                        f"{path}: a terrain has one band of heights, but this file "
                        f"has {file.count}; write the band of heights to a separate "
                        "file."
                    )
                if np.dtype(file.dtypes[0]).kind not in "iuf":
                    raise InputError(
                        f"{path}: heights must be real numbers, but the band holds "
                        f"{file.dtypes[0]}."
                    )
                require_cells(path, (file.height, file.width), max_cells)
                if file.crs is not None:
                    geodesy.require_earth(path, file.crs)
                require_heights(path, file, stated)
                heights_in = vertical(
                    path,
                    file.crs,
                    file.units[0],
                    stated.height_unit,
                    stated.heights,
                    _descriptions(file),
                )
                unit_m = heights_in.unit_m
                band = file.read(1, masked=True)
                remarks = (*heights_in.remarks, *doubts(path, file, band, stated))
                scale, offset = file.scales[0], file.offsets[0]
                transform, crs, driver = file.transform, file.crs, file.driver
                nodata = file.nodata
                has_points = transform.is_identity and bool(file.gcps[0])
                _require_place(path, transform)
                if crs is not None and not has_points:
                    middle = file.xy(0.5 * file.height, 0.5 * file.width, offset="ul")
                    geodesy.require_agreement(path, horizontal(crs), *middle)
    except (RasterioError, OSError, ValueError):
        raise InputError(f"{path}: {why_unreadable(path)}") from None
    if has_points:
        raise InputError(
            f"{path}: has control points instead of a place; warp it to them first "
            "(gdalwarp IN.tif OUT.tif)."
        )
    if scale == 0 or not (math.isfinite(scale) and math.isfinite(offset)):
        raise InputError(
            f"{path}: its scale, {scale:g}, and offset, {offset:g}, turn all cells into one height "
            "or none; correct them (gdal_edit -scale 1 -offset 0 FILE)."
        )
    numbers = band.data
    heights = numbers.astype(np.float64)
    declared, of_srtm = np.ma.getmaskarray(band), heights == UNDECLARED_VOID
    heights[declared | ~np.isfinite(heights) | of_srtm] = np.nan
    facts = {
        "driver": driver,
        "crs": None if crs is None else geodesy.crs_name(crs),
        "heights": heights_in.facts,
        "declared_void": None if nodata is None or math.isnan(nodata) else nodata,
    }
    left = int((of_srtm & ~declared).sum())
    reading, voids = named(Reading(facts, remarks), numbers, stated)
    if voids is not None:
        heights[voids] = np.nan
        left = 0 if UNDECLARED_VOID in stated.marks else left
    return Raster(
        path.stem,
        str(path),
        (heights * scale + offset) * unit_m,
        transform,
        crs,
        (scale * unit_m, offset * unit_m),
        heights_in,
        marked(reading, [Mark(UNDECLARED_VOID, left)] if left else ()),
        stated,
    )


@contextlib.contextmanager
def _opened_alone(path: Path) -> Iterator[DatasetReader]:
    """Open a raster that contains all its heights itself.

    Raises
    ------
    InputError
        If it has any other format, or names a file.
    """
    # Drivers check the first bytes, so a misleading file name does not open anything else.
    with rasterio.Env(GDAL_DISABLE_READDIR_ON_OPEN="EMPTY_DIR", GDAL_PAM_ENABLED="NO"):
        for driver in SELF_CONTAINED:
            try:
                file = rasterio.open(path, driver=driver)
            except RasterioError:
                continue
            with file:
                # Overviews of a GeoTIFF may be in a file at any path.
                if "OVERVIEWS" in file.tag_namespaces():
                    raise InputError(
                        f"{path}: names a file of overviews; write it again without, with "
                        "gdal_translate for example."
                    )
                if file.crs is not None:
                    require_own_crs(path, file.crs.to_wkt())
                yield file
            return
    other = kind_of_content(path)
    if other is not None:
        raise InputError(f"{path}: {other}")
    raise InputError(
        f"{path}: cannot be read as a raster that holds its heights itself; give a GeoTIFF, an "
        "SRTM .hgt, an ASCII grid, or a .npy or .npz file. A format that names other files, such "
        "as VRT, is converted with gdal_translate, or named when the desk is started."
    )


def _descriptions(file: DatasetReader) -> list[str]:
    """Return the texts of a file that may name the unit of its heights, unless it scales them."""
    if (file.scales[0], file.offsets[0]) != (1.0, 0.0):
        return []
    tags = {**file.tags(), **file.tags(1)}
    units = [f"{key}={value}" for key, value in tags.items() if _UNIT_TAG.fullmatch(key)]
    return [file.descriptions[0] or "", *units]


def _require_place(path: Path, transform: Affine) -> None:
    """Check that the transform is finite and invertible.

    Raises
    ------
    InputError
        If it is not.
    """
    if not all(map(math.isfinite, transform)) or transform.determinant == 0:
        raise InputError(
            f"{path}: its place is no grid, by the numbers {', '.join(map(str, transform[:6]))}; "
            "write it again with the corner and the sides of its cells."
        )


def _require_readable(path: Path, most: int, seen: set[Path], depth: int = 0) -> None:
    """Check that a raster and its parts are not devices, and have blocks of at most ``most`` cells.

    GDAL reads whole blocks, however few of their cells are requested.

    Raises
    ------
    InputError
        If a check fails, or virtual rasters are nested too deeply.
    OSError, ValueError, RasterioError
        If one cannot be read.
    """
    if depth > _MOST_DEPTH:
        raise InputError(
            f"{path}: is nested in more than {_MOST_DEPTH} virtual rasters, each made of the next; "
            "give the heights as a GeoTIFF, with gdal_translate for example."
        )
    if not path.is_dir():
        require_regular(path)
        for source in vrt.sources(path):
            if source not in seen:
                seen.add(source)
                _require_readable(source, most, seen, depth + 1)
    _require_regular_beside(path)
    with rasterio.open(path) as file:
        _require_blocks(path, file, most)


def _require_blocks(path: Path, file: DatasetReader, most: int) -> None:
    """Check that no block of a raster has more than ``most`` cells.

    Raises
    ------
    InputError
        If one does.
    """
    if any(rows * columns > most for rows, columns in file.block_shapes):
        rows, columns = max(file.block_shapes, key=math.prod)
        raise InputError(
            f"{path}: is stored in blocks of {rows} x {columns} cells, more than "
            f"{most:,}; write it again with smaller ones, with gdal_translate for example."
        )


def _require_regular_beside(path: Path) -> None:
    """Check the files that GDAL may open with a raster: files of the same name, or a whole folder.

    Raises
    ------
    InputError
        If reading one would block or never end.
    """
    folder, start = (path, "") if path.is_dir() else (path.parent, f"{path.stem}.")
    try:
        files = list(folder.iterdir())
    except PermissionError:
        # The folder may still be searchable.
        return
    for file in files:
        if not file.name.startswith(start) or file.is_dir() or not exists(file):
            continue
        try:
            require_regular(file)
        except InputError:
            raise InputError(
                f"{file}: belongs to the raster {path.name} by its name, and is a pipe or a "
                "device; remove it or copy it into a regular file."
            ) from None


def north_up(raster: Raster) -> Raster:
    """Turn a raster so that row 0 is the northernmost and column 0 the westernmost.

    Raises
    ------
    InputError
        If its rows do not run along the axes of its coordinates.
    """
    transform, heights = raster.transform, raster.heights
    if transform.b != 0 or transform.d != 0:
        raise InputError(
            f"{raster.name}: the raster is rotated against its coordinate axes; "
            "warp it to north up first, with gdalwarp for example."
        )
    rows, columns = heights.shape
    width, west, height, north = transform.a, transform.c, transform.e, transform.f
    if height > 0:
        heights, height, north = heights[::-1], -height, north + rows * height
    if width < 0:
        heights, width, west = heights[:, ::-1], -width, west + columns * width
    return replace(raster, heights=heights, transform=Affine(width, 0, west, 0, height, north))
