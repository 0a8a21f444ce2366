"""The files that a virtual raster of GDAL (VRT) names, which GDAL would open silently."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree import ElementTree as ET

from pathgene.host.errors import InputError
from pathgene.host.inputs import exists, opened, read_text


__all__ = ["sources"]

# GDAL treats a file as virtual if its first bytes contain this word, whatever its name is.
_ROOT = b"<VRTDataset"
_HEAD_BYTES = 1024
# Elements, attributes and metadata keys whose text GDAL opens: sources, the source of a warped
# raster, its heights and positions, overviews.
_NAMING = (
    "sourcefilename", "sourcedataset", "dempath", "rpc_dem", "x_dataset", "y_dataset",
    "overview_file",
)  # fmt: skip
# Arguments of a processed raster.
_ARGUMENT = "dataset_filename"


def sources(path: Path) -> Iterator[Path]:
    """Yield the files that a virtual raster names; nothing for any other file.

    Raises
    ------
    InputError
        If ``path`` is not a regular file, is virtual and larger than a text may be, or names
        anything except files: GDAL would wait for a pipe in ``/vsisubfile/0_9,PIPE`` or in a nested
        XML text.
    OSError, ValueError
        If it cannot be read, or is virtual but not XML.
    """
    with opened(path) as file:
        if _ROOT not in file.read(_HEAD_BYTES):
            return
    try:
        root = ET.fromstring(read_text(path))
    except ET.ParseError as error:
        raise ValueError(f"no XML: {error}") from None
    for element in root.iter():
        values = {_folded(name): value for name, value in element.items()}
        for name in _names(element, values):
            is_relative = values.get("relativetovrt", "0") != "0"
            named = path.parent / name if is_relative else Path(name)
            if not _is_plain(name) or not exists(named) or named.is_dir():
                raise InputError(
                    f"{path}: names the source {name!r}, which is not a file; a virtual raster "
                    "may be made of files only, so name one, or give its heights as a GeoTIFF."
                )
            yield named


def _names(element: ET.Element, values: Mapping[str, str]) -> Iterator[str]:
    """Yield the names in an element; GDAL reads attributes as elements and ignores case."""
    key = (values.get("key") or values.get("name") or "").lower()
    if _folded(element.tag) in _NAMING or key in _NAMING or _ARGUMENT in key:
        yield "".join(element.itertext())
    yield from (value for name, value in values.items() if name in _NAMING)


def _folded(name: str) -> str:
    """Return a name without its namespace, in lower case."""
    return name.rpartition("}")[2].lower()


def _is_plain(name: str) -> bool:
    """Return whether GDAL treats a name as a file, not as a subdataset or XML."""
    return not name.startswith(("<", "\\", "/vsi")) and ":" not in name.partition("/")[0]
