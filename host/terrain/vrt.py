"""The files that a virtual raster of GDAL (VRT) names, which GDAL would open unseen."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

from host.inputs import exists, opened, read_text


__all__ = ["sources"]

# GDAL takes a file for virtual by this word in its first bytes, whatever its name.
_ROOT = b"<VRTDataset"
_HEAD_BYTES = 1024


def sources(path: Path) -> Iterator[Path]:
    """Yield the files that a virtual raster names and that exist; none of another file.

    Raises
    ------
    InputError
        If ``path`` is no regular file, or is virtual and larger than a text may be.
    OSError, ValueError
        If it cannot be read, or is virtual and no XML.
    """
    with opened(path) as file:
        if _ROOT not in file.read(_HEAD_BYTES):
            return
    try:
        root = ET.fromstring(read_text(path))
    except ET.ParseError as error:
        raise ValueError(f"no XML: {error}") from None
    for element in root.iter():
        # Sources, and the rasters that a warped one is made of.
        if element.tag in ("SourceFilename", "SourceDataset") and element.text:
            is_relative = "1" in (element.get("relativeToVRT"), element.get("relativetoVRT"))
            named = path.parent / element.text if is_relative else Path(element.text)
            if exists(named):
                yield named
