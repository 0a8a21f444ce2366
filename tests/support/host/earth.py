"""Positions on Earth by PROJ, without our own conversions."""

import numpy as np
import pyproj


#: Files and PROJ agree within a centimetre.
AGREE_M = 0.01


def places(terrain, points):
    """Return latitude and longitude of local metres, (n,) each."""
    points = np.asarray(points)
    system = pyproj.CRS.from_user_input(terrain.crs)
    to_wgs84 = pyproj.Transformer.from_crs(system, "EPSG:4326", always_xy=True)
    east, north = terrain.origin
    unit = system.axis_info[0].unit_conversion_factor
    lon, lat = to_wgs84.transform(east + points[:, 0] / unit, north + points[:, 1] / unit)
    return lat, lon


def apart_m(first, second):
    """Return the metres between pairs of (latitude, longitude) on the ellipsoid."""
    (lat_a, lon_a), (lat_b, lon_b) = first, second
    return pyproj.Geod(ellps="WGS84").inv(lon_a, lat_a, lon_b, lat_b)[2]


def agree(terrain, points, lat, lon):
    """Return whether points of a file lie where the local ones are."""
    return bool(np.max(apart_m(places(terrain, points), (lat, lon))) < AGREE_M)


def single(value):
    """Return a number as MAVLink carries it, in single precision."""
    return float(np.float32(value))
