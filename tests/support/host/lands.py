"""Files with heights of known terrain in any reference system, made by PROJ, not by our code."""

import functools
import warnings

import numpy as np
import pyproj
import rasterio
from affine import Affine
from pyproj.database import query_crs_info
from pyproj.enums import PJType


GEODESICS = pyproj.Geod(ellps="WGS84")


class Land:
    """Rolling ground around a place, with a height for each latitude and longitude."""

    def __init__(self, lat, lon, *, mean=600.0, relief=60.0, wave_m=3000.0):
        self.lat, self.lon = lat, lon
        self._mean, self._relief, self._wave_m = mean, relief, wave_m

    def metres(self, lat, lon):
        """Return metres east and north of the place, accurate to a thousandth nearby."""
        north = np.radians(lat - self.lat) * 6_371_000
        turned = (np.asarray(lon) - self.lon + 180) % 360 - 180
        return np.radians(turned) * 6_371_000 * np.cos(np.radians(self.lat)), north

    def height(self, lat, lon):
        """Return heights in metres."""
        east, north = (2 * np.pi * each / self._wave_m for each in self.metres(lat, lon))
        return self._mean + self._relief * (np.sin(east) + np.cos(0.7 * north)) / 2


def write(file, land, crs, *, cells=20, cell_m=50.0, unit=None, unit_m=1.0, dtype="float64"):
    """Write a square of land around its place as a GeoTIFF in a reference system.

    Returns False if the system has no such place.
    """
    system = pyproj.CRS.from_user_input(crs)
    try:
        to_system = pyproj.Transformer.from_crs("EPSG:4326", system, always_xy=True)
    except pyproj.exceptions.ProjError:
        return False
    x, y = to_system.transform(land.lon, land.lat)
    if not np.isfinite([x, y]).all():
        return False
    back = pyproj.Transformer.from_crs(system, "EPSG:4326", always_xy=True)
    step = 1e-3 if system.is_geographic else 100.0
    lon, lat = back.transform([x - step, x + step, x, x], [y, y, y - step, y + step])
    if not np.isfinite([lon, lat]).all():
        return False
    east, north = GEODESICS.inv(lon[::2], lat[::2], lon[1::2], lat[1::2])[2]
    dx, dy = 2 * step * cell_m / east, 2 * step * cell_m / north
    place = Affine(dx, 0, x - cells / 2 * dx, 0, -dy, y + cells / 2 * dy)
    column, row = np.meshgrid(np.arange(cells) + 0.5, np.arange(cells) + 0.5)
    lon, lat = back.transform(place.c + dx * column, place.f - dy * row)
    heights = land.height(np.asarray(lat), np.asarray(lon)) / unit_m
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with rasterio.open(
            file, "w", driver="GTiff", height=cells, width=cells, count=1, dtype=dtype,
            crs=system.to_wkt(), transform=place,
        ) as made:  # fmt: skip
            made.write(heights.astype(dtype), 1)
            if unit is not None:
                made.units = (unit,)
    return True


@functools.cache
def known_systems(kind):
    """Return all systems of EPSG of a kind that PROJ knows."""
    return query_crs_info("EPSG", [kind])


def systems(rng, kind=None):
    """Yield systems of EPSG of a kind at random, each with a place in its area of use.

    Without a kind they are projected, and one in eight is geographic.
    """
    while True:
        own = kind
        if own is None:
            is_projected = rng.integers(8) > 0
            own = PJType.PROJECTED_CRS if is_projected else PJType.GEOGRAPHIC_2D_CRS
        known = known_systems(own)
        found = known[rng.integers(len(known))]
        area = found.area_of_use
        if area is None:
            continue
        east = area.east + (360 if area.east < area.west else 0)
        lat = area.south + rng.uniform(0.2, 0.8) * (area.north - area.south)
        lon = area.west + rng.uniform(0.2, 0.8) * (east - area.west)
        if abs(lat) < 84:
            yield f"EPSG:{found.code}", float(lat), float((lon + 180) % 360 - 180)


def misread_m(file, crs):
    """Return the metres between the middles of a file in its own system and in another one.

    PROJ alone places both.
    """
    with rasterio.open(file) as made:
        middle = made.xy(made.height / 2, made.width / 2, offset="ul")
        systems = made.crs.to_wkt(version="WKT2_2019"), crs
    away = [
        pyproj.Transformer.from_crs(each, "EPSG:4326", always_xy=True).transform(*middle)
        for each in systems
    ]
    return GEODESICS.inv(*away[0], *away[1])[2]


def write_geoid(file):
    """Write a geoid that is a plane in longitude and latitude, and return it."""

    def geoid(lon, lat):
        return 40.0 + 0.1 * lon + 0.05 * lat

    lon, lat = np.meshgrid(np.arange(-180, 180, 1.0), np.arange(90, -91, -1.0))
    with rasterio.open(
        file, "w", driver="GTiff", height=181, width=360, count=1, dtype="float32",
        crs="EPSG:4326", transform=Affine(1, 0, -180.5, 0, -1, 90.5),
    ) as made:  # fmt: skip
        made.write(geoid(lon, lat).astype("float32"), 1)
        made.update_tags(TYPE="VERTICAL_OFFSET_GEOGRAPHIC_TO_VERTICAL", AREA_OR_POINT="Point")
        made.update_tags(1, DESCRIPTION="geoid_undulation", UNITTYPE="metre")
    return geoid
