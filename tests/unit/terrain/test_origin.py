"""A place on Earth for a terrain without one."""

import numpy as np
import pyproj
import pytest

from pathgene.host.errors import InputError
from pathgene.host.terrain import Terrain
from pathgene.host.terrain.origin import at_origin


PLAIN = Terrain("plain", np.zeros((101, 101)), 200.0, 200.0)


@pytest.mark.parametrize(
    ("lat", "lon"), [(46.1, 7.6), (-33.9, 151.2), (0.0, -179.99), (78.0, 15.6)]
)
def test_lies_where_proj_has_it(lat, lon):
    """The reference follows geodesics; 20 km from the origin the projection is 7 cm off."""
    terrain = at_origin(PLAIN, lat, lon)
    geodesic = pyproj.Geod(ellps="WGS84")
    for x, y in ((0, 0), (0, 5000), (5000, 0), (3000, 4000), (12_000, 16_000)):
        far = np.hypot(x, y)
        east, north, _ = geodesic.fwd(lon, lat, np.degrees(np.arctan2(x, y)), far)
        found = terrain.to_geographic(float(x), float(y))
        apart = geodesic.inv(east, north, found[1], found[0])[2]
        assert apart < max(0.002, 1e-14 * far**3), (x, y)
        assert np.allclose(terrain.to_local(*found), (x, y), atol=1e-4)


def test_refuses_what_is_no_place():
    with pytest.raises(InputError) as refusal:
        at_origin(PLAIN, 146.1, 7.6)
    assert str(refusal.value) == (
        "The latitude of the origin must be from -90 to 90 degrees, not 146.1; latitude comes "
        "first (--origin LAT,LON, or origin under [terrain] in a problem file)."
    )
    with pytest.raises(InputError, match=r"^The longitude of the origin must be from -180 to 180"):
        at_origin(PLAIN, 46.1, float("nan"))


def test_refuses_a_terrain_that_has_a_place():
    with pytest.raises(InputError) as refusal:
        at_origin(at_origin(PLAIN, 46.1, 7.6), 46.1, 7.6)
    assert str(refusal.value) == (
        "The terrain 'plain' states its place on Earth; leave the origin out (--origin, or "
        "origin under [terrain] in a problem file)."
    )


@pytest.mark.parametrize(("nodes", "is_read"), [(91, True), (121, False)])
def test_refuses_a_terrain_that_is_too_wide(nodes, is_read):
    """East of the origin the metres of its frame grow longer."""
    wide = Terrain("wide", np.zeros((20, nodes)), 2_000.0, 2_000.0)
    if is_read:
        assert at_origin(wide, 46.1, 7.6).metric.is_metric
        return
    with pytest.raises(InputError) as refusal:
        at_origin(wide, 46.1, 7.6)
    assert str(refusal.value) == (
        "The terrain 'wide' is 240 x 38 km large, and its metres differ from true metres by 0.07% "
        "east of its origin; cut out the part you need, at most 200 km from west to east."
    )
