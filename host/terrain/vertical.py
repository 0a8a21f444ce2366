"""Unit and datum of heights, as a file states them."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pyproj
from numpy.typing import NDArray
from pyproj.exceptions import ProjError
from pyproj.transformer import TransformerGroup
from rasterio.crs import CRS
from rasterio.enums import WktVersion

from pathgene.host.errors import InputError
from pathgene.host.remarks import Grade, Remark
from pathgene.host.terrain.datum import ELLIPSOID, Vertical
from pathgene.host.terrain.stated import HEIGHT_UNITS


__all__ = ["geoid_heights", "horizontal", "vertical"]

Floats = NDArray[np.float64]


# Metres per unit of height, by the unit's name in files.
_UNITS_M = {
    "m": 1.0,
    "metre": 1.0,
    "metres": 1.0,
    "meter": 1.0,
    "meters": 1.0,
    "ft": 0.3048,
    "foot": 0.3048,
    "feet": 0.3048,
    "international foot": 0.3048,
    "us-ft": 1200 / 3937,
    "ftus": 1200 / 3937,
    "us survey foot": 1200 / 3937,
    "us_survey_foot": 1200 / 3937,
    "cm": 0.01,
    "centimetre": 0.01,
    "centimetres": 0.01,
    "centimeter": 0.01,
    "centimeters": 0.01,
    "dm": 0.1,
    "decimetre": 0.1,
    "decimetres": 0.1,
    "decimeter": 0.1,
    "decimeters": 0.1,
    "km": 1000.0,
}
# Units other than the metre in a description of heights.
_NAMES_UNIT = re.compile(
    r"(?<![a-z])(us[- _]?)?(ft|feet|foot|dm|cm|(deci|centi)-?met(re|er)s?)(us)?(?![a-z])",
    re.IGNORECASE,
)
# Share by which two spellings of one unit differ at most; a US survey foot is another foot.
_SAME_UNIT = 1e-9
# A plane whose unit lies between these, in metres, is in a kind of feet.
_FEET_M = (0.29, 0.32)
# WGS84 with heights above the ellipsoid, and above the geoid EGM96.
_ELLIPSOIDAL, _ABOVE_SEA = "EPSG:4979", "EPSG:9707"


def vertical(
    path: Path,
    crs: CRS | None,
    band_unit: str | None,
    height_unit: str | None = None,
    heights: str | None = None,
    hints: Iterable[str] = (),
) -> Vertical:
    """Return unit and datum of heights.

    Parameters
    ----------
    path : Path
        The file.
    crs : CRS or None
        Its reference system.
    band_unit : str or None
        Unit that its band states.
    height_unit : str, optional
        Unit that the user states, a key of
        :data:`pathgene.host.terrain.stated.HEIGHT_UNITS`; it overrides the file.
    heights : str, optional
        Reference that the user states, one of
        :data:`pathgene.host.terrain.stated.HEIGHTS`; it overrides the file.
    hints : iterable of str, optional
        Descriptions of the heights, which may name a unit.

    Raises
    ------
    InputError
        If the unit is unknown, or missing although the plane is in feet or a description names
        feet, decimetres or centimetres.
    """
    system = None if crs is None else _pyproj(crs)
    axis = None if system is None else _vertical_axis(system)
    hints = tuple(hints)
    unit, unit_m, unit_from = _unit(path, system, axis, band_unit, height_unit, hints)
    remarks = tuple(_contradictions(axis, band_unit, height_unit, hints))
    if axis is not None and axis[2] == "down":
        unit_m = -unit_m
    datum, datum_from, is_ellipsoidal = "mean sea level", "assumed", False
    if axis is not None:
        datum, is_ellipsoidal, datum_from = axis[3], axis[4], "file"
    if heights is not None:
        if heights == "sea-level" and is_ellipsoidal:
            datum, is_ellipsoidal = "mean sea level", False
        elif heights == "ellipsoidal" and not is_ellipsoidal:
            datum, is_ellipsoidal = ELLIPSOID, True
        datum_from = "option"
    name = "" if system is None else system.name
    return Vertical(unit, unit_m, unit_from, datum, datum_from, is_ellipsoidal, name, remarks)


def horizontal(crs: CRS) -> CRS:
    """Return the plane of a reference system, without its heights."""
    system = _pyproj(crs)
    if system is None or not (system.is_compound or len(system.axis_info) > 2):
        return crs
    if system.is_geocentric:
        return crs
    plane = system.sub_crs_list[0] if system.is_compound else system
    return CRS.from_wkt(plane.to_2d().to_wkt())


def geoid_heights(lon: Floats, lat: Floats) -> Floats | None:
    """Return heights of the geoid EGM96 above the ellipsoid, or None if PROJ has no grid."""
    with warnings.catch_warnings():
        # pyproj warns of a missing grid; the caller's sentence says so.
        warnings.simplefilter("ignore")
        group = TransformerGroup(_ELLIPSOIDAL, _ABOVE_SEA, always_xy=True)
    if not group.best_available or not group.transformers:
        return None
    try:
        _, _, height = group.transformers[0].transform(lon, lat, np.zeros_like(lon), errcheck=True)
    except ProjError:
        return None
    below = -np.asarray(height, dtype=np.float64)
    return below if np.isfinite(below).all() and below.any() else None


def _unit(
    path: Path,
    system: pyproj.CRS | None,
    axis: tuple[str, float, str, str, bool] | None,
    band_unit: str | None,
    height_unit: str | None,
    hints: Iterable[str],
) -> tuple[str, float, str]:
    """Return name, metres and origin of the unit of heights."""
    if height_unit is not None:
        return height_unit, HEIGHT_UNITS[height_unit], "option"
    stated = (band_unit or "").strip()
    if stated:
        try:
            return stated, _UNITS_M[stated.lower()], "file"
        except KeyError:
            raise InputError(
                f"{path}: its heights are in {band_unit!r}, which is unknown; convert them to "
                f"metres, or state their unit (--height-unit {'|'.join(HEIGHT_UNITS)})."
            ) from None
    if axis is not None:
        return axis[0], axis[1], "file"
    for hint in hints:
        if _NAMES_UNIT.search(hint):
            raise InputError(
                f"{path}: its heights are described as {hint!r}, and it states no unit of heights; "
                f"state it (--height-unit {'|'.join(HEIGHT_UNITS)})."
            )
    plane = system.axis_info[0] if system is not None and system.axis_info else None
    if plane is not None and _FEET_M[0] < plane.unit_conversion_factor < _FEET_M[1]:
        raise InputError(
            f"{path}: its plane is in feet ({plane.unit_name}), and it states no unit of heights; "
            "state it (--height-unit m|ft|us-ft)."
        )
    return "m", 1.0, "assumed"


def _contradictions(
    axis: tuple[str, float, str, str, bool] | None,
    band_unit: str | None,
    height_unit: str | None,
    hints: Iterable[str],
) -> Iterator[Remark]:
    """Yield a warning if the file states another unit of heights than the user or its own band."""
    stated = (band_unit or "").strip()
    found: list[tuple[str, float | None]] = []
    if stated and height_unit is not None:
        found.append((f"the band states {stated!r}", _UNITS_M.get(stated.lower())))
    elif axis is not None:
        found.append((f"the reference system states {axis[0]!r}", axis[1]))
    elif height_unit is not None:
        words = ((hint, _NAMES_UNIT.search(hint)) for hint in hints)
        found += [
            (f"the file says {hint!r}", _metres(word.group())) for hint, word in words if word
        ]
    if height_unit is not None:
        unit, unit_m, by = height_unit, HEIGHT_UNITS[height_unit], "--height-unit states"
        remedy = "leave the option out, or correct it, if the file is right"
    else:
        unit, unit_m, by = stated, _UNITS_M.get(stated.lower(), math.nan), "the band states"
        remedy = f"state the unit (--height-unit {'|'.join(HEIGHT_UNITS)})"
    for source, metres in found[:1]:
        if metres and stated != height_unit and not _is_same(metres, unit_m):
            text = f"Heights are in {unit}, as {by}, but {source}; {remedy}."
            yield Remark(Grade.WARNING, text)


def _is_same(one_m: float, other_m: float) -> bool:
    """Return whether two units have the same length, or one of them none."""
    return math.isnan(other_m) or math.isclose(one_m, other_m, rel_tol=_SAME_UNIT)


def _metres(word: str) -> float | None:
    """Return the metres of a unit that a description names."""
    plain = re.sub("[- _]", "", word.lower())
    if plain.startswith("us") or plain.endswith("us"):
        return HEIGHT_UNITS["us-ft"]
    return _UNITS_M.get(plain)


def _vertical_axis(system: pyproj.CRS) -> tuple[str, float, str, str, bool] | None:
    """Return unit, its metres, direction, datum and whether it is the ellipsoid, or None."""
    if system.is_geocentric:
        return None
    if system.is_compound:
        upright = system.sub_crs_list[-1]
        if not upright.is_vertical:
            return None
        is_ellipsoidal = "ellipsoid" in f"{upright.name} {upright.datum}".lower()
        axis = upright.axis_info[0]
        datum = ELLIPSOID if is_ellipsoidal else upright.name
    elif len(system.axis_info) == 3:
        axis, datum, is_ellipsoidal = system.axis_info[2], ELLIPSOID, True
    else:
        return None
    return axis.unit_name, axis.unit_conversion_factor, axis.direction, datum, is_ellipsoidal


def _pyproj(crs: CRS) -> pyproj.CRS | None:
    """Return a reference system with its axes, or None if PROJ does not know it."""
    try:
        return pyproj.CRS.from_wkt(crs.to_wkt(version=WktVersion.WKT2_2019))
    except (ProjError, ValueError):
        return None
