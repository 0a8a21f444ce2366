import itertools

import numpy as np
import pytest
from affine import Affine
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pathgene.host.errors import InputError
from pathgene.host.terrain import load, warp


HEIGHTS = np.array([[10, 20, 30], [40, 50, 60]], dtype=np.float32)


def refusal(source):
    with pytest.raises(InputError) as error:
        load(source)
    return str(error.value)


class TestGeographic:
    PIXEL = 1 / 1200

    def plane(self, shape, west=8.3, north=46.5):
        """Return heights that rise 1 m per pixel eastwards and 2 m per pixel northwards."""
        rows, columns = shape
        heights = np.add.outer(2.0 * np.arange(rows)[::-1], 1.0 * np.arange(columns)) + 100
        return heights, Affine(self.PIXEL, 0, west, 0, -self.PIXEL, north)

    def test_interpolates_between_pixel_centres(self, write_tif):
        heights, transform = self.plane((60, 80))
        terrain = load(write_tif(heights, transform, "EPSG:4326"))
        assert terrain.crs == "EPSG:32632"
        assert not terrain.voids.any()
        iy, ix = np.indices(terrain.shape)
        lat, lon = terrain.to_geographic(ix * terrain.dx_m, iy * terrain.dy_m)
        column = np.clip((lon - transform.c) / self.PIXEL - 0.5, 0, 79)
        row = np.clip((transform.f - lat) / self.PIXEL - 0.5, 0, 59)
        np.testing.assert_allclose(terrain.elevation, 100 + 2 * (59 - row) + column, atol=1e-6)

    def test_cells_are_square_of_the_smaller_side(self, write_tif):
        heights, transform = self.plane((60, 80))
        terrain = load(write_tif(heights, transform, "EPSG:4326"))
        # An arc of the parallel at the centre, 46.475 N, on the ellipsoid.
        sine = np.sin(np.radians(46.475))
        radius_m = 6_378_137 / np.sqrt(1 - 0.0066943799901413165 * sine**2)
        parallel_m = np.radians(self.PIXEL) * radius_m * np.sqrt(1 - sine**2)
        assert terrain.dx_m == terrain.dy_m == pytest.approx(parallel_m, abs=0.006)
        paper = terrain.on_paper
        assert paper.dx_m == paper.dy_m == round(paper.dx_m, 2)
        assert paper.dx_m == pytest.approx(parallel_m * 0.99963, abs=0.006)

    @pytest.mark.parametrize(
        ("west", "north", "crs"),
        [
            (8.3, 46.5, "EPSG:32632"),
            (-84.4, 36.5, "EPSG:32616"),
            (-71.2, -33.0, "EPSG:32719"),
            (179.95, -17.0, "EPSG:32760"),
            (359.9, 10.0, "EPSG:32630"),
            (-0.02, 0.02, "EPSG:32730"),
        ],
    )
    def test_anywhere(self, write_tif, west, north, crs):
        """No wedge remains and little is lost in any zone, on the equator and the antimeridian."""
        heights, transform = self.plane((50, 40), west, north)
        terrain = load(write_tif(heights, transform, "EPSG:4326"))
        assert terrain.crs == crs
        assert not terrain.voids.any()
        lat, lon = terrain.to_geographic([0.0, terrain.width_m], [0.0, terrain.height_m])
        lon = west + (lon - west) % 360
        assert west <= lon[0] < lon[1] <= west + 40 * self.PIXEL
        assert north - 50 * self.PIXEL <= lat[0] < lat[1] <= north
        assert lat[1] - lat[0] > 46 * self.PIXEL
        assert lon[1] - lon[0] > 35 * self.PIXEL

    def test_a_void_spreads_to_what_it_touches(self, write_tif):
        heights, transform = self.plane((60, 80))
        heights[30, 40] = np.nan
        terrain = load(write_tif(heights, transform, "EPSG:4326"))
        iy, ix = np.indices(terrain.shape)
        lat, lon = terrain.to_geographic(ix * terrain.dx_m, iy * terrain.dy_m)
        near = (np.abs((lon - transform.c) / self.PIXEL - 40.5) < 1) & (
            np.abs((transform.f - lat) / self.PIXEL - 30.5) < 1
        )
        assert near.any()
        np.testing.assert_array_equal(terrain.voids, near)

    def test_voids_at_the_edge_are_no_wedges(self, write_tif):
        heights, transform = self.plane((60, 80))
        whole = load(write_tif(heights, transform, "EPSG:4326"))
        heights[:, :20] = np.nan
        halved = load(write_tif(heights, transform, "EPSG:4326"))
        assert halved.shape == whole.shape
        assert halved.origin == whole.origin
        assert halved.voids[:, :18].all()
        assert not halved.voids[:, 25:].any()

    def test_too_large(self, write_tif):
        file = write_tif(HEIGHTS, Affine(10, 0, 0, 0, -10, 40), "EPSG:4326")
        assert refusal(file) == (
            "made: the raster spans 30 x 20 degrees, more than the 12 that one "
            "map can show; cut out the part you need."
        )

    def test_beyond_utm(self, write_tif):
        heights, transform = self.plane((60, 80), north=86.0)
        terrain = load(write_tif(heights, transform, "EPSG:4326"))
        assert "Transverse_Mercator" in terrain.crs
        assert abs(terrain.metric.convergence_at_middle_deg) < 0.01
        lat, lon = terrain.to_geographic(0.5 * terrain.width_m, 0.5 * terrain.height_m)
        assert (lat, lon) == pytest.approx((86 - 0.025, 8.3 + 40 / 1200), abs=0.01)

    def test_too_small(self, write_tif):
        file = write_tif(HEIGHTS, Affine(1e-8, 0, 0, 0, -1e-8, 5), "EPSG:4326")
        assert refusal(file) == (
            "made: its cells are smaller than a centimetre; check its coordinate reference system."
        )


class TestLargestRectangle:
    @given(arrays(np.bool_, st.tuples(st.integers(1, 6), st.integers(1, 6))))
    def test_matches_a_search_of_all(self, usable):
        rows, columns = warp.largest_rectangle(usable)
        assert usable[rows, columns].all()
        best = max(
            (
                (bottom - top) * (right - left)
                for top, bottom in itertools.combinations(range(usable.shape[0] + 1), 2)
                for left, right in itertools.combinations(range(usable.shape[1] + 1), 2)
                if usable[top:bottom, left:right].all()
            ),
            default=0,
        )
        assert (rows.stop - rows.start) * (columns.stop - columns.start) == best

    def test_in_a_parallelogram(self):
        row, column = np.indices((100, 100))
        usable = (column >= row // 10) & (column < 90 + row // 10)
        assert warp.largest_rectangle(usable) == (slice(0, 100), slice(9, 90))


def test_the_grid_may_not_be_far_larger_than_the_raster(write_tif):
    """Cells have 5 degrees by 11 cm; square cells of 11 cm would take terabytes."""
    file = write_tif(np.ones((2, 2)), Affine(5, 0, 10, 0, -1e-6, 50), "EPSG:4326")
    assert refusal(file) == (
        "made: in square cells of the smaller side, 0.11 m, it has 108990 x 6513753, more than "
        "50,000,000; cut it, make it coarser, or allow more (--max-cells)."
    )


def test_a_grid_in_blocks(write_tif, monkeypatch):
    """The heights do not depend on how many rows are resampled at a time."""
    heights = np.random.default_rng(1).uniform(0, 1000, (40, 50))
    file = write_tif(heights, Affine(1 / 1200, 0, 8.3, 0, -1 / 1200, 46.5), "EPSG:4326")
    whole = load(file).elevation
    monkeypatch.setattr(warp, "_BLOCK_NODES", 200)
    np.testing.assert_allclose(load(file).elevation, whole, rtol=0, atol=1e-6)
