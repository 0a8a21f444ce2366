"""Coordinate reference systems: units, names, and conversion between them."""

from __future__ import annotations

import math
import re
import warnings
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

import numpy as np
import pyproj
import rasterio
from numpy.typing import NDArray
from pyproj.exceptions import ProjError
from rasterio._err import CPLE_BaseError  # GDAL's errors, which no public module exports.
from rasterio.crs import CRS
from rasterio.enums import WktVersion
from rasterio.errors import CRSError, RasterioError
from rasterio.warp import transform as warp_transform

from pathgene.host.errors import InputError


__all__ = [
    "WGS84",
    "LocalFrame",
    "crs_name",
    "crs_short",
    "is_like_wgs84",
    "its_crs",
    "known_crs",
    "local_crs",
    "place_points",
    "require_agreement",
    "require_earth",
    "transform",
    "unit_m",
    "utm_zone",
]

Floats = NDArray[np.float64]
_Number = TypeVar("_Number", float, Floats)

#: Longitude and latitude in degrees, in this order.
WGS84 = "EPSG:4326"

# Words for a system without a name, and the words of files for it.
_NAMELESS = "its reference system"
_NO_NAMES = ("", "unknown", "unnamed", "undefined", "custom")

# Geocentric datums that agree with WGS84 within a metre or two, less than any cell of a terrain:
# they count as WGS84 if no grid of corrections is installed.
_LIKE_WGS84 = re.compile(
    r"WGS.?(19)?84|World Geodetic System 1984|ITRF|International Terrestrial"
    r"|ETRS|European Terrestrial|NAD.?83|North American Datum 1983"
    r"|GDA.?(19)?94|GDA.?2020|Geocentric Datum of Australia"
    r"|NZGD.?2000|New Zealand Geodetic Datum 2000|SIRGAS"
    r"|JGD.?20(00|11)|Japanese Geodetic Datum 20(00|11)|CGCS.?2000|China 2000|CH1903\+"
    r"|RGF.?(19)?93|Reseau Geodesique Francais 1993",
    re.IGNORECASE,
)


# Metres between a point by the parameters of a reference system and by its name that are too many.
_DISAGREE_M = 1.0
# Radii of the Earth's ellipsoids and spheres, and of other bodies that have maps.
_EARTH_KM = (6_300.0, 6_450.0)
_BODIES_KM = {"Mercury": 2_440.0, "Venus": 6_052.0, "the Moon": 1_737.0, "Mars": 3_396.0}
_NEAR_KM = 10.0


def crs_name(crs: CRS) -> str:
    """Return ``EPSG:<code>`` of a reference system, or its WKT."""
    code = crs.to_epsg()
    return f"EPSG:{code}" if code is not None else str(crs.to_wkt())


def crs_short(crs: CRS) -> str:
    """Return a reference system in a sentence: its code, its name, or words if it has none."""
    name = crs_name(crs)
    if len(name) < 20:
        return name
    words = name.split('"')
    short = words[1].strip() if len(words) > 1 else name[:40]
    return _NAMELESS if short.lower() in _NO_NAMES else short


def its_crs(crs: CRS) -> str:
    """Return a reference system in a sentence, as a part of its file."""
    short = crs_short(crs)
    return short if short == _NAMELESS else f"{_NAMELESS} {short}"


def utm_zone(lat: float, lon: float) -> str:
    """Return the UTM zone on WGS84 of a point in degrees, as ``EPSG:<code>``."""
    zone = int((lon + 180.0) % 360.0 // 6.0) + 1
    return f"EPSG:{(32600 if lat >= 0 else 32700) + zone}"


def local_crs(lat: float, lon: float) -> str:
    """Return a reference system in metres east and north of a point in degrees, as WKT.

    It is the transverse Mercator projection around the point, on WGS84, without a scale factor:
    north is up at the point, and 20 km away lengths are accurate to 5 millionths.
    """
    parameters = f"+lat_0={lat!r} +lon_0={lon!r} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m"
    return str(CRS.from_proj4(f"+proj=tmerc {parameters} +no_defs").to_wkt())


@lru_cache(maxsize=64)
def known_crs(text: str) -> CRS:
    """Return a reference system by its name, its WKT or its PROJ string.

    Raises
    ------
    InputError
        If there is no such reference system.
    """
    try:
        # Within an environment, GDAL raises its errors instead of printing some of them.
        with rasterio.Env():
            crs = CRS.from_user_input(text)
            crs.to_wkt()
    except (RasterioError, CRSError, CPLE_BaseError, ValueError):
        raise InputError(
            f"{text[:60]!r} is no coordinate reference system; give EPSG:CODE or WKT."
        ) from None
    return crs


def require_earth(file: str | Path, crs: CRS) -> None:
    """Check that a reference system is one of the Earth.

    Raises
    ------
    InputError
        If its ellipsoid has the size of another body.
    """
    try:
        system = pyproj.CRS.from_wkt(crs.to_wkt())
    except (ProjError, CRSError, CPLE_BaseError):
        return
    if system.ellipsoid is None:
        return
    radius_km = 1e-3 * system.ellipsoid.semi_major_metre
    if _EARTH_KM[0] < radius_km < _EARTH_KM[1]:
        return
    body = next((name for name, km in _BODIES_KM.items() if abs(km - radius_km) < _NEAR_KM), None)
    raise InputError(
        f"{file}: its reference system {system.name!r} is of {body or 'another body'}, with a "
        f"radius of {radius_km:,.0f} km, and not of the Earth; give a terrain on the Earth, or one "
        "without a reference system."
    )


def require_agreement(file: str | Path, plane: CRS, x: float, y: float) -> None:
    """Check that the parameters of a reference system agree with its name.

    GDAL loses the code of a system that it cannot read back, and a part of its parameters: the
    sphere of EPSG:9311 in a GeoTIFF.

    Parameters
    ----------
    plane : CRS
        The system, without its heights.
    x, y : float
        A point of the map, by which both are compared.

    Raises
    ------
    InputError
        If PROJ has a system of the same name and units that places the point elsewhere.
    """
    if plane.to_epsg() is not None:
        return
    try:
        system = pyproj.CRS.from_wkt(plane.to_wkt(version=WktVersion.WKT2_2019))
        if system.is_bound and system.source_crs is not None:
            system = system.source_crs
        known = pyproj.CRS.from_user_input(system.name)
        if known.name.casefold() != system.name.casefold() or not known.is_projected:
            return
        units = [[each.unit_conversion_factor for each in own.axis_info] for own in (system, known)]
        if not np.allclose(units[0], units[1], rtol=1e-9):
            return
        # Before any shift of the datum, which a file may state in its own way.
        read, named = (
            pyproj.Transformer.from_crs(own, own.geodetic_crs, always_xy=True).transform(
                x, y, errcheck=True
            )
            for own in (system, known)
        )
    except (ProjError, CRSError, CPLE_BaseError, ValueError):
        return
    away_m = pyproj.Geod(ellps="WGS84").inv(*read, *named)[2]
    if not away_m > _DISAGREE_M:
        return
    code = known.to_authority()
    name = ":".join(code) if code else f"{known.name!r}"
    raise InputError(
        f"{file}: its reference system has the name of {name}, {known.name!r}, but other "
        f"parameters, which GDAL reads from it, and the two place the middle of the map "
        f"{away_m:,.0f} m apart; if {name} is right, write the file again by it (gdalwarp -s_srs "
        f"{name} -t_srs EPSG:4326 IN.tif OUT.tif), else correct the name."
    )


@lru_cache(maxsize=64)
def unit_m(crs: str) -> float:
    """Return the metres per linear unit of a projected reference system; 1 without such a unit."""
    try:
        return float(known_crs(crs).linear_units_factor[1])
    except (InputError, CRSError):
        return 1.0


@dataclass(frozen=True)
class LocalFrame:
    """Metres east and north of a point in a projected reference system.

    Parameters
    ----------
    crs : str
        ``EPSG:<code>`` or WKT.
    origin : tuple of float
        Easting and northing of the origin, in the system's units.
    metres_per_unit : tuple of float, optional
        Metres on the ground for a unit of easting and of northing, by default the unit's own.
    """

    crs: str
    origin: tuple[float, float]
    metres_per_unit: tuple[float, float] = (math.nan, math.nan)

    def __post_init__(self) -> None:
        if math.isnan(self.metres_per_unit[0]):
            object.__setattr__(self, "metres_per_unit", (unit_m(self.crs),) * 2)

    def from_wgs84(self, lat: Floats, lon: Floats) -> tuple[Floats, Floats]:
        """Return local metres of degrees, arrays of one shape; see :func:`transform`."""
        return self.from_grid(*transform(WGS84, self.crs, lon, lat))

    def from_grid(self, eastings: _Number, northings: _Number) -> tuple[_Number, _Number]:
        """Return local metres of eastings and northings in the system's units."""
        (east, north), (unit_x, unit_y) = self.origin, self.metres_per_unit
        return (eastings - east) * unit_x, (northings - north) * unit_y

    def to_wgs84(self, x: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return latitude and longitude in degrees of local metres; see :func:`transform`."""
        (east, north), (unit_x, unit_y) = self.origin, self.metres_per_unit
        lon, lat = transform(self.crs, WGS84, east + x / unit_x, north + y / unit_y)
        return lat, lon


def transform(source: str, target: str, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Convert points from one reference system to another.

    Parameters
    ----------
    source, target : str
        Reference systems; for a geographic one, the order is longitude, latitude in degrees.
    x, y : ndarray
        Coordinates, of one shape.

    Returns
    -------
    tuple of ndarray
        Coordinates in ``target``, of the same shape.

    Raises
    ------
    InputError
        If a latitude is beyond a pole, or a point cannot be expressed in ``target``.

    Warns
    -----
    UserWarning
        Once per reference system, if its datum can only be shifted approximately here.
    """
    if source == WGS84 and bool((np.abs(y) > 90).any()):
        worst = float(y.flat[int(np.argmax(np.abs(y)))])
        raise InputError(f"A latitude must lie between -90 and 90 degrees, but one is {worst:g}.")
    for crs in (source, target):
        _warn_if_approximate(crs)
    return place_points(source, target, x, y)


def place_points(source: str, target: str, x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Convert points as :func:`transform` does, without a word on the datum.

    Raises
    ------
    InputError
        If a point cannot be expressed in ``target``.
    """
    try:
        moved = warp_transform(source, target, x.ravel().tolist(), y.ravel().tolist())
    except (RasterioError, CRSError, CPLE_BaseError):
        moved = ([np.inf], [np.inf])
    if not np.isfinite(moved).all():
        raise InputError(
            "A point cannot be placed in the terrain's coordinate reference system; "
            "check its coordinates, latitude before longitude."
        )
    east, north = (np.asarray(values, dtype=np.float64).reshape(x.shape) for values in moved)
    return east, north


@lru_cache(maxsize=64)
def _warn_if_approximate(crs: str) -> None:
    if not is_like_wgs84(crs):
        warnings.warn(
            f"The exact shift between the datum {_datum(crs)!r} and WGS84 needs grid files that "
            "are not installed, so latitudes and longitudes may be some metres off.",
            # The caller of the terrain's method.
            stacklevel=5,
        )


def is_like_wgs84(crs: str) -> bool:
    """Return whether a reference system has a datum that agrees with WGS84 within some metres."""
    return _LIKE_WGS84.search(_datum(crs)) is not None


def _datum(crs: str) -> str:
    found = re.search(r'(?:DATUM|ENSEMBLE)\["([^"]+)"', known_crs(crs).to_wkt())
    return found.group(1).replace("_", " ") if found else "unknown"
