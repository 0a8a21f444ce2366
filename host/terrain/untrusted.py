"""Terrain files from untrusted sources: limited cells, and no references to other files."""

from __future__ import annotations

import io
import math
import re
import zipfile
import zlib
from pathlib import Path
from tokenize import TokenError
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from pathgene.host.errors import InputError


__all__ = [
    "MAX_CELLS",
    "SELF_CONTAINED",
    "UNREADABLE",
    "read_array",
    "read_cells",
    "read_values",
    "require_cells",
    "require_own_crs",
]

#: Maximum cells of a terrain unless the user allows more: 200 MB of heights.
MAX_CELLS = 25_000_000

#: Raster formats of GDAL that contain all their heights themselves. No other format is on the list,
#: because some of them name files of this machine or addresses in a network: VRT, GTI, MRF, WMS,
#: WMTS, STACTA, HFA, HDF5, KMLSUPEROVERLAY, the XML of satellites.
SELF_CONTAINED = (
    "GTiff", "SRTMHGT", "AAIGrid", "GRASSASCIIGrid", "GSAG", "GSBG", "GS7BG", "USGSDEM", "DTED",
    "BT", "Terragen", "HF2", "SIGDEM", "GXF", "GTX", "ZMap", "PNG", "XYZ",
)  # fmt: skip

#: Errors that a damaged file in numpy's formats raises: RuntimeError for an encrypted member,
#: KeyError for a missing one, OverflowError and TypeError for an impossible shape.
UNREADABLE = (
    OSError,
    ValueError,
    EOFError,
    KeyError,
    OverflowError,
    TokenError,
    RuntimeError,
    TypeError,
    zipfile.BadZipFile,
    zlib.error,
)

# Maximum bytes of a cell, and of any other value: the definition of a reference system can be pages
# long.
_CELL_BYTES, _VALUE_BYTES = 16, 1 << 16
# Maximum values of a member other than the cells: sides, a place.
_MOST_VALUES = 16
# Maximum bytes of an array's header; numpy itself refuses a header of 10,000.
_HEADER_BYTES = 1 << 14
# A reference system by its code, or as text: any other text could be a path or an address, which
# GDAL would open.
_STATED_CRS = re.compile(r"\s*([A-Za-z]+:\d+\s*$|[A-Za-z_]+\s*[\[(]|\+proj=|\{)")
# A part of a reference system that names a file of corrections.
_NAMED_FILE = re.compile(
    r"PROJ4_GRIDS|PARAMETERFILE|(?:grids|file|model)\s*=\s*(?!@null\b)|\binit\s*=", re.IGNORECASE
)
# Advice for a file with too many cells.
_REMEDY = "cut it, make it coarser, or allow more (--max-cells)"


def require_cells(
    path: Path, shape: tuple[int, ...], max_cells: int | None, remedy: str = _REMEDY
) -> None:
    """Check the number of cells that a file states before they are read.

    Raises
    ------
    InputError
        If there are more than ``max_cells``, by default :data:`MAX_CELLS`.
    """
    most = MAX_CELLS if max_cells is None else max_cells
    if math.prod(shape) > most:
        raise InputError(
            f"{path}: its {' x '.join(map(str, shape))} cells are more than {most:,}; {remedy}."
        )


def require_own_crs(path: Path, text: str) -> None:
    """Check that a reference system names neither a file nor an address.

    Raises
    ------
    InputError
        If it does.
    """
    if not _STATED_CRS.match(text) or _NAMED_FILE.search(text):
        raise InputError(
            f"{path}: its reference system names a file; write the terrain again in a system with "
            "an EPSG code, with gdalwarp for example."
        )


def read_array(
    path: Path, opened: BinaryIO, max_cells: int | None, remedy: str = _REMEDY
) -> NDArray[Any]:
    """Read an array of cells in numpy's format, header first, from the beginning of a file.

    Raises
    ------
    InputError
        If it has more cells than ``max_cells``.
    OSError, ValueError, EOFError
        If it cannot be read.
    """
    require_cells(path, _shape(opened, _CELL_BYTES), max_cells, remedy)
    opened.seek(0)
    return np.lib.format.read_array(opened, allow_pickle=False)


def read_cells(
    path: Path, archive: zipfile.ZipFile, key: str, max_cells: int | None
) -> NDArray[Any]:
    """Read the cells of an ``.npz``, as :func:`read_array` does."""
    with _member(archive, key) as member:
        require_cells(path, _shape(member, _CELL_BYTES), max_cells)
    with _member(archive, key) as member:
        return np.lib.format.read_array(member, allow_pickle=False)


def read_values(archive: zipfile.ZipFile, key: str) -> NDArray[Any]:
    """Read a few values of an ``.npz``.

    Raises
    ------
    ValueError
        If there are more than 16.
    """
    with _member(archive, key) as member:
        shape = _shape(member, _VALUE_BYTES)
    if math.prod(shape) > _MOST_VALUES:
        raise ValueError(f"{math.prod(shape)} values of {key}")
    with _member(archive, key) as member:
        return np.lib.format.read_array(member, allow_pickle=False)


def _member(archive: zipfile.ZipFile, key: str) -> Any:
    """Open an array of an ``.npz`` that is compressed as by numpy."""
    info = archive.getinfo(f"{key}.npy")
    # Other kinds of decompression may allocate gigabytes before the first byte.
    if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"compression {info.compress_type}")
    return archive.open(info)


def _shape(opened: Any, most_bytes: int) -> tuple[int, ...]:
    """Return the shape that a header states; the header's length is not trusted."""
    header = io.BytesIO(opened.read(_HEADER_BYTES))
    version = np.lib.format.read_magic(header)
    read = (
        np.lib.format.read_array_header_1_0
        if version == (1, 0)
        else np.lib.format.read_array_header_2_0
    )
    shape, _, kind = read(header)
    if min(shape, default=0) < 0:
        raise ValueError(f"sides {shape}")
    if kind.itemsize > most_bytes:
        raise ValueError(f"values of {kind.itemsize} bytes")
    return shape
