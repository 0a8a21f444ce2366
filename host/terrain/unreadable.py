"""Reasons why a file is no raster of heights: its content is of another kind, or cut short."""

from __future__ import annotations

import re
from pathlib import Path


__all__ = ["kind_of_content", "why_unreadable"]

# Points a side of SRTM's tiles of 3 and of 1 arc-second, and their names.
_HGT_SIDES = (1201, 3601)
_HGT_NAME = re.compile(r"[NS]\d\d[EW]\d{3}\.", re.IGNORECASE)
# Bytes from which the kind of a file is known.
_HEAD_BYTES = 4096
# Kinds of files: a pattern of their first bytes, and a sentence with the mend.
_KINDS = (
    (
        rb"\x1f\x8b|BZh|\xfd7zXZ|PK\x03\x04|7z\xbc\xaf|Rar!",
        "is packed; unpack it, and give the raster in it.",
    ),
    (rb"version https://git-lfs", "is a pointer of git-lfs, not the file; get it (git lfs pull)."),
    (rb"<(!doctype\s+)?html\b", "is a web page: the download failed; get the file again."),
    (
        rb"\{.*\"(Feature|FeatureCollection|GeometryCollection|(Multi)?Polygon)\"|(<\?xml.*)?<kml\b",
        "holds zones, not heights; give it with --nofly.",
    ),
    (rb"(II|MM)(\*\0|\0\*|\+\0|\0\+)", "is a TIFF that is cut short or damaged; get it again."),
)


def why_unreadable(path: Path) -> str:
    """Return why a file cannot be read as a raster, and how to fix it."""
    kind = kind_of_content(path)
    if kind is not None:
        return kind
    if path.suffix.lower() == ".hgt" and path.is_file():
        size = path.stat().st_size
        sides = [f"{2 * side * side:,}" for side in _HGT_SIDES]
        if size not in (2 * side * side for side in _HGT_SIDES):
            return (
                f"an SRTM .hgt of {' or '.join(map(str, _HGT_SIDES))} points a side has "
                f"{' or '.join(sides)} bytes, but this file has {size:,}: it is cut short or no "
                "such tile; get it again."
            )
        if not _HGT_NAME.match(path.name):
            return (
                "an SRTM .hgt states its place only in its name, the south-west corner in "
                f"degrees such as N46E008.hgt; name it so again, unlike {path.name!r}."
            )
    return (
        "cannot be read as a raster of heights; give a GeoTIFF, an SRTM .hgt, another format that "
        "GDAL reads, or a .npy or .npz file."
    )


def kind_of_content(path: Path) -> str | None:
    """Return the kind of a file that is no raster, in a sentence with the mend, or None."""
    if path.is_dir():
        return (
            "is a folder; give a file, and join several tiles first (gdalbuildvrt ALL.vrt "
            f"{path.absolute().name}/*.tif)."
        )
    try:
        with path.open("rb") as opened:
            head = opened.read(_HEAD_BYTES)
    except OSError:
        return None
    if not head:
        return "is empty; get it again."
    start = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    for pattern, sentence in _KINDS:
        if re.match(pattern, start, re.IGNORECASE | re.DOTALL):
            return sentence
    return None
