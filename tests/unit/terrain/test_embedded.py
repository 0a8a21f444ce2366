import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.terrain import embedded, load, names


def test_every_name_is_described_and_loads():
    assert names() == ("jacksboro", "canyon", "river", "large-canyon")
    assert tuple(entry.name for entry in embedded.describe()) == names()
    for entry in embedded.describe():
        assert all(entry)
        terrain = load(entry.name)
        assert terrain.name == entry.name
        assert not terrain.voids.any()


def test_refuses_an_unknown_name():
    with pytest.raises(InputError) as error:
        embedded.load("atlantis")
    assert str(error.value) == (
        "There is no embedded terrain 'atlantis', only jacksboro, canyon, river, large-canyon."
    )


class TestJacksboro:
    """Landmarks of Campbell and Anderson counties, Tennessee."""

    TERRAIN = load("jacksboro")

    def test_grid(self):
        assert self.TERRAIN.crs == "EPSG:32616"
        # 3 seconds of parallel at 36.303 N: 74.8 m.
        assert self.TERRAIN.dx_m == self.TERRAIN.dy_m == pytest.approx(74.85, abs=0.1)
        assert self.TERRAIN.width_m == pytest.approx(403 * 74.85, rel=0.04)
        assert self.TERRAIN.height_m == pytest.approx(344 * 92.48, rel=0.04)

    def test_the_summit_is_cross_mountain(self):
        heights = self.TERRAIN.elevation
        iy, ix = np.unravel_index(int(np.argmax(heights)), heights.shape)
        lat, lon = self.TERRAIN.to_geographic(ix * self.TERRAIN.dx_m, iy * self.TERRAIN.dy_m)
        # 36°11′54″ N, 84°13′50″ W, 3534 feet, to a cell; its node lies a little below the summit.
        assert (lat, lon) == pytest.approx((36.19833, -84.23056), abs=0.001)
        assert heights[iy, ix] == pytest.approx(3534 * 0.3048, abs=10)

    @pytest.mark.parametrize(
        ("place", "lat", "lon", "height_m"),
        [
            ("Jacksboro", 36.330, -84.184, 325),
            ("LaFollette", 36.383, -84.120, 325),
            ("Caryville", 36.300, -84.223, 335),
            ("Rocky Top", 36.219, -84.155, 262),
        ],
    )
    def test_towns_lie_in_their_valleys(self, place, lat, lon, height_m):
        x, y = self.TERRAIN.to_local(lat, lon)
        assert self.TERRAIN.ground(x, y) == pytest.approx(height_m, abs=25), place
