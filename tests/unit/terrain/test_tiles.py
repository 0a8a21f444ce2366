"""The tiles of real ground, if they are available."""

from pathlib import Path

import numpy as np
import pytest
import rasterio

from pathgene.host.terrain import info, load
from tests.support.host.earth import true_sides


TILES = Path(__file__).parents[4] / "shared" / "terrain"


class TestRealTiles:
    PROJECTED = {
        # Shape, cell, lowest and highest metres, and WGS84 bounds: west, south, east, north.
        "big_tujunga_canyon_ca": (
            (512, 512),
            30,
            589,
            2085,
            (-118.21496, 34.25195, -118.04618, 34.39199),
        ),
        "cdem_indian_river_bc": (
            (512, 512),
            30,
            154,
            2012,
            (-122.98161, 49.55589, -122.76858, 49.69428),
        ),
        "himalaya_gorge_np": (
            (512, 512),
            90,
            500,
            5447.75,
            (86.13856, 27.30239, 86.60747, 27.72047),
        ),
        "st_helens_wa": ((452, 310), 30, 705, 2543, (-122.24987, 46.12586, -122.12757, 46.24874)),
    }
    # Bounds of the file, share of voids.
    GEOGRAPHIC = {
        "alps_jungfrau_voids_ch": ((7.99958, 46.12042, 8.42625, 46.54708), 0.0424, "EPSG:32632"),
        "jervis_inlet_fjord_bc": (
            (-124.00042, 49.49042, -123.57375, 49.91708),
            0.0336,
            "EPSG:32610",
        ),
    }

    @staticmethod
    def tile(name):
        file = TILES / f"{name}.tif"
        if not file.exists():
            pytest.skip(f"the terrain tile {file.name} is not at hand")
        return file

    @pytest.mark.filterwarnings("ignore:The exact shift between the datum")
    @pytest.mark.parametrize("name", PROJECTED)
    def test_projected_keeps_its_cells(self, name):
        shape, side, lowest, highest, (west, south, east, north) = self.PROJECTED[name]
        file = self.tile(name)
        terrain = load(file)
        assert terrain.shape == shape
        assert terrain.on_paper.dx_m == terrain.on_paper.dy_m == side
        assert (terrain.lowest, terrain.highest) == (lowest, highest)
        assert not terrain.voids.any()
        with rasterio.open(file) as raster:
            np.testing.assert_array_equal(terrain.elevation[::-1], raster.read(1))
            assert terrain.origin == raster.xy(shape[0] - 1, 0)
            middle = raster.xy(shape[0] // 2, shape[1] // 2)
            sides = true_sides(raster.crs.to_wkt(), *middle, side, side)
        assert (terrain.dx_m, terrain.dy_m) == pytest.approx(sides, rel=2e-6)
        corners = info(terrain)["corners"].values()
        assert all(south < lat < north and west < lon < east for lat, lon in corners)

    @pytest.mark.parametrize("name", GEOGRAPHIC)
    def test_geographic_lies_where_the_file_does(self, name):
        (west, south, east, north), void_share, crs = self.GEOGRAPHIC[name]
        file = self.tile(name)
        terrain = load(file)
        assert terrain.crs == crs
        # Voids grow by the cells they touch; wedges do not count.
        assert void_share < terrain.voids.mean() < 2 * void_share
        lats, lons = zip(*info(terrain)["corners"].values(), strict=True)
        assert min(lats) >= south
        assert max(lats) <= north
        assert min(lons) >= west
        assert max(lons) <= east
        rng = np.random.default_rng(7)
        ix, iy = rng.integers(terrain.shape[1], size=500), rng.integers(terrain.shape[0], size=500)
        lat, lon = terrain.to_geographic(ix * terrain.dx_m, iy * terrain.dy_m)
        heights = terrain.elevation[iy, ix]
        known = ~np.isnan(heights)
        with rasterio.open(file) as raster:
            pixels = np.pad(raster.read(1), 1, mode="edge")
            rows, columns = rasterio.transform.rowcol(raster.transform, lon, lat)
        # Within the pixels around its pixel.
        around = np.stack(
            [
                pixels[np.asarray(rows) + dy, np.asarray(columns) + dx]
                for dy in range(3)
                for dx in range(3)
            ]
        )
        inner = known & (around > -1000).all(axis=0)
        assert inner.sum() > 400
        assert (heights >= around.min(axis=0))[inner].all()
        assert (heights <= around.max(axis=0))[inner].all()

    @pytest.mark.parametrize("name", GEOGRAPHIC)
    def test_voids_can_be_filled(self, name):
        file = self.tile(name)
        kept, filled = load(file), load(file, fill_voids=True)
        assert not filled.voids.any()
        assert filled.shape == kept.shape
        np.testing.assert_array_equal(filled.elevation[~kept.voids], kept.elevation[~kept.voids])
        assert kept.lowest - 100 < filled.lowest
        assert filled.highest < kept.highest + 200
