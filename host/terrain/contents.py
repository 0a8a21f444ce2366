"""Rasters that hold slopes, directions, shades or colours instead of heights."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rasterio.enums import ColorInterp
from rasterio.io import DatasetReader

from pathgene.host.errors import InputError
from pathgene.host.remarks import Grade, Remark
from pathgene.host.terrain.file_heights import neighbours
from pathgene.host.terrain.stated import HEIGHT_UNITS, Stated


__all__ = ["doubts", "require_heights"]

# Words for rasters that are computed from heights or that show land.
_OTHER = re.compile(
    r"hill[ _-]?shad(?:e|ing)|shaded[ _-]?relief|(?<![a-z])(?:slopes?|aspects?|gradients?|curvature"
    r"|rough(?:ness)?|rugged(?:ness)?|tri|tpi|ndvi|intensity|reflectance|orthophoto|land[ _-]?cover"
    r"|population|temperature|precipitation|errors?|uncertainty|accuracy|tid)(?![a-z])",
    re.IGNORECASE,
)
_HEIGHTS = re.compile(
    r"elev|height|altitude|topo|bathy|depth|(?<![a-z])(?:n?dem|dtm|dsm|dgm|dom|mnt|srtm|z)(?![a-z])",
    re.IGNORECASE,
)
# Heights of things above the ground.
_ABOVE_GROUND = re.compile(
    r"(?:canopy|vegetation|tree|building)[ _-]?heights?|height above ground"
    r"|(?<![a-z])(?:chm|ndsm)(?![a-z])",
    re.IGNORECASE,
)
_DEPTHS = re.compile(r"(?<![a-z])(?:depths?|soundings?)(?![a-z])", re.IGNORECASE)
_ELLIPSOID = re.compile(r"ellipsoid|(?<![a-z])hae(?![a-z])", re.IGNORECASE)
# Units of slopes and directions.
_ANGLES = frozenset(
    {"degree", "degrees", "deg", "°", "percent", "%", "radian", "radians", "rad", "gon", "grad"}
)
# Tags of a band for its quantity, and of a file for its contents.
_OF_BAND = ("description", "long_name", "standard_name", "name")
_OF_FILE = ("tifftag_imagedescription", "description", "title", "layer_type", "content")
_ACCEPT = f"state the unit if they are heights (--height-unit {'|'.join(HEIGHT_UNITS)})"
# Different numbers between 0 and 1 that are no heights.
_MANY = 20
# Directions: their range, and the share of steps of more than half a turn between neighbours.
_TURN, _FIRST, _LAST, _SHARE = 360.0, 10.0, 350.0, 0.01


def require_heights(path: Path, file: DatasetReader, stated: Stated) -> None:
    """Check that the one band of a raster does not state that it holds something else.

    Raises
    ------
    InputError
        If its colours, unit or description say so, and the user does not state a unit of heights.
    """
    if stated.height_unit is not None:
        return
    if file.colorinterp[0] is ColorInterp.palette and file.dtypes[0] == "uint8":
        raise InputError(
            f"{path}: its numbers are colours of a palette, not heights; give the heights, or "
            f"{_ACCEPT}."
        )
    unit = (file.units[0] or "").strip()
    if unit.lower() in _ANGLES:
        raise InputError(
            f"{path}: its unit is {unit!r}, as for slopes or directions, not for heights; give the "
            f"heights, or {_ACCEPT}."
        )
    tags = {key.lower(): value for key, value in file.tags(1).items()}
    for text in (file.descriptions[0], *map(tags.get, _OF_BAND)):
        word = _other(text)
        if word:
            raise InputError(
                f"{path}: its band is described as {str(text)[:80]!r}, so it holds no heights but "
                f"{word}; give the heights, or {_ACCEPT}."
            )


def doubts(
    path: Path, file: DatasetReader, numbers: np.ma.MaskedArray[Any, Any], stated: Stated
) -> Iterator[Remark]:
    """Yield warnings of a raster that may hold something other than heights above the sea."""
    described = file.descriptions[0] or ""
    if stated.heights is None and _ELLIPSOID.search(described):
        yield Remark(
            Grade.WARNING,
            f"The band is described as {described[:80]!r}, and heights count from the sea; state "
            "from where they count (--heights sea-level|ellipsoidal).",
        )
    if _DEPTHS.search(described) and _are_above_0(numbers):
        yield Remark(
            Grade.WARNING,
            f"The band is described as {described[:80]!r}, and its numbers are above 0, so depths "
            "count as heights; change their sign in the file.",
        )
    if stated.height_unit is not None or file.units[0]:
        return
    tags = {key.lower(): value for key, value in file.tags().items()}
    named = ((path.stem, "its name"), *((tags.get(key), "its description") for key in _OF_FILE))
    for text, what in named:
        if _other(text):
            yield _doubt(f"{what}, {str(text)[:80]!r}, does not sound like heights")
            return
    if (file.scales[0], file.offsets[0]) != (1.0, 0.0):
        return
    if file.dtypes[0] in ("uint8", "int8"):
        yield _doubt("its numbers are bytes, as in a picture such as a hillshade")
    elif _are_directions(numbers.data):
        yield _doubt("its numbers are directions of 0 to 360 degrees, as of slopes")
    elif _are_shares(numbers):
        yield _doubt("all its numbers are between 0 and 1, as shares or kilometres")


def _doubt(reason: str) -> Remark:
    text = f"The terrain may hold no heights: {reason}; give the heights, or {_ACCEPT}."
    return Remark(Grade.WARNING, text)


def _other(text: str | None) -> str:
    """Return the word for something other than heights in a text that names no heights."""
    if not text:
        return ""
    found = _ABOVE_GROUND.search(text)
    if found is None and not _HEIGHTS.search(text):
        found = _OTHER.search(text)
    return found.group().lower() if found else ""


def _known(numbers: np.ma.MaskedArray[Any, Any]) -> NDArray[Any]:
    """Return the numbers that are no declared voids."""
    plain = numbers.compressed()
    known: NDArray[Any] = plain[np.isfinite(plain)]
    return known


def _are_above_0(numbers: np.ma.MaskedArray[Any, Any]) -> bool:
    """Return whether most numbers are above 0."""
    known = _known(numbers)
    return bool(known.size and np.median(known) > 0)


def _are_shares(numbers: np.ma.MaskedArray[Any, Any]) -> bool:
    """Return whether many different numbers lie between 0 and 1."""
    if numbers.dtype.kind != "f":
        return False
    known = _known(numbers)
    if not known.size or known.min() < 0 or known.max() > 1:
        return False
    return len(np.unique(known)) >= _MANY


def _are_directions(numbers: NDArray[Any]) -> bool:
    """Return whether numbers fill a full turn, and jump across north between neighbours."""
    known = np.where((numbers >= 0) & (numbers <= _TURN), numbers, np.nan).astype(np.float64)
    is_turn = ~np.isnan(known)
    others = numbers[~is_turn & np.isfinite(numbers)]
    # Flat cells hold one mark.
    if not is_turn.any() or (len(others) and (others != others[0]).any()):
        return False
    if not (np.nanmin(known) < _FIRST and np.nanmax(known) > _LAST):
        return False
    jumps = steps = 0
    for one, other in neighbours(known):
        step = np.abs(one - other)
        steps += int(np.count_nonzero(~np.isnan(step)))
        jumps += int(np.count_nonzero(step > _TURN / 2))
    return jumps > _SHARE * steps
