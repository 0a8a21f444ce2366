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
    unit_x, unit_y = terrain.metres_per_unit or (unit, unit)
    lon, lat = to_wgs84.transform(east + points[:, 0] / unit_x, north + points[:, 1] / unit_y)
    return lat, lon


def true_sides(crs, x, y, dx, dy):
    """Return the geodesic lengths of a cell around a point of a reference system, metres."""
    to_wgs84 = pyproj.Transformer.from_crs(crs, "EPSG:4326", always_xy=True)
    lon, lat = to_wgs84.transform([x - dx, x + dx, x, x], [y, y, y - dy, y + dy])
    lengths = pyproj.Geod(ellps="WGS84").inv(lon[::2], lat[::2], lon[1::2], lat[1::2])[2]
    return lengths[0] / 2, lengths[1] / 2


def apart_m(first, second):
    """Return the metres between pairs of (latitude, longitude) on the ellipsoid."""
    (lat_a, lon_a), (lat_b, lon_b) = first, second
    return pyproj.Geod(ellps="WGS84").inv(lon_a, lat_a, lon_b, lat_b)[2]


def agree(terrain, points, lat, lon):
    """Return whether points of a file agree with local points."""
    return bool(np.max(apart_m(places(terrain, points), (lat, lon))) < AGREE_M)


def single(value):
    """Return a number in single precision, as in MAVLink."""
    return float(np.float32(value))
