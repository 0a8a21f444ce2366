from pathlib import Path

import numpy as np
import pytest
import rasterio
import rasterio.shutil
from affine import Affine

from pathgene.host.errors import InputError
from pathgene.host.terrain import load
from pathgene.host.terrain.stated import Stated
from tests.support.host.earth import true_sides


TILES = Path(__file__).parents[4] / "shared" / "terrain"
UTM = "EPSG:32632"
# Rows from the north, as in a file.
HEIGHTS = np.array([[10, 20, 30], [40, 50, 60]], dtype=np.float32)
SOUTH_FIRST = [[40.0, 50.0, 60.0], [10.0, 20.0, 30.0]]


def refusal(source, **options):
    with pytest.raises(InputError) as error:
        load(source, **options)
    return str(error.value)


@pytest.fixture
def tif(tmp_path):
    return tmp_path / "made.tif"


class TestProjected:
    def test_nodes_are_pixel_centres(self, tif, write_tif):
        terrain = load(write_tif(HEIGHTS))
        assert terrain.name == "made"
        assert terrain.source == str(tif)
        assert terrain.elevation.tolist() == SOUTH_FIRST
        sides = true_sides(UTM, 500_045, 5_099_970, 30, 30)
        assert (terrain.dx_m, terrain.dy_m) == pytest.approx(sides, rel=1e-7)
        assert sides == pytest.approx((30.012, 30.012), abs=1e-4)
        assert terrain.crs == UTM
        assert terrain.origin == (500_015.0, 5_100_000 - 45.0)

    def test_cells_may_be_rectangular(self, write_tif):
        terrain = load(write_tif(HEIGHTS, transform=Affine(25, 0, 500_000, 0, -40, 0)))
        sides = true_sides(UTM, 500_037.5, -40, 25, 40)
        assert (terrain.dx_m, terrain.dy_m) == pytest.approx(sides, rel=1e-7)
        assert terrain.origin == (500_012.5, -60.0)

    @pytest.mark.parametrize(("width", "height"), [(30, 30), (-30, -30), (-30, 30)])
    def test_other_orientations(self, write_tif, width, height):
        """The ground is the same whichever corner the file begins with."""
        heights = HEIGHTS[:: 1 if height < 0 else -1, :: 1 if width > 0 else -1]
        transform = Affine(
            width,
            0,
            500_000 + (90 if width < 0 else 0),
            0,
            height,
            5_100_000 - (60 if height > 0 else 0),
        )
        terrain = load(write_tif(heights, transform))
        assert terrain.elevation.tolist() == SOUTH_FIRST
        assert terrain.origin == (500_015.0, 5_100_000 - 45.0)

    def test_feet_on_the_ground_become_metres(self, write_tif):
        file = write_tif(HEIGHTS, Affine(30, 0, 1_300_000, 0, -30, 300_000), "EPSG:2285")
        terrain = load(file, stated=Stated("m"))
        assert (terrain.dx_m, terrain.dy_m) == pytest.approx((30 * 1200 / 3937,) * 2, rel=1e-4)
        assert terrain.origin == (1_300_015.0, 300_000 - 45.0)
        assert terrain.elevation.tolist() == SOUTH_FIRST

    @pytest.mark.parametrize(
        ("unit", "metres"),
        [
            ("m", 1),
            ("metre", 1),
            ("ft", 0.3048),
            ("Feet", 0.3048),
            ("US survey foot", 1200 / 3937),
            ("Decimeters", 0.1),
            ("centimetres", 0.01),
        ],
    )
    def test_feet_of_height_become_metres(self, write_tif, unit, metres):
        terrain = load(write_tif(HEIGHTS, unit=unit))
        np.testing.assert_allclose(terrain.elevation, np.array(SOUTH_FIRST) * metres, rtol=1e-15)

    def test_scale_and_offset_of_the_band_count(self, tif, write_tif):
        write_tif(HEIGHTS.astype(np.int16))
        with rasterio.open(tif, "r+") as made:
            made.scales, made.offsets = (0.5,), (100.0,)
        assert load(tif).elevation.tolist() == [[120, 125, 130], [105, 110, 115]]

    @pytest.mark.parametrize("nodata", [-32768, 0, 32767])
    def test_declared_nodata_is_void(self, write_tif, nodata):
        heights = HEIGHTS.astype(np.int16)
        heights[0, 1] = nodata
        terrain = load(write_tif(heights, nodata=nodata))
        assert terrain.voids.tolist() == [[False] * 3, [False, True, False]]
        assert (terrain.lowest, terrain.highest) == (10.0, 60.0)

    def test_nan_and_infinity_are_void(self, write_tif):
        heights = HEIGHTS.copy()
        heights[0] = np.nan, np.inf, 30
        assert load(write_tif(heights)).voids.tolist() == [[False] * 3, [True, True, False]]

    def test_without_an_epsg_code_the_crs_is_wkt(self, write_tif):
        crs = "+proj=tmerc +lat_0=46 +lon_0=8 +x_0=1000 +y_0=2000 +datum=WGS84 +units=m"
        terrain = load(write_tif(HEIGHTS, crs=crs, transform=Affine(30, 0, 985, 0, -30, 2045)))
        assert terrain.crs.startswith("PROJCS[")
        assert terrain.origin == (1000.0, 2000.0)
        assert terrain.to_geographic(0.0, 0.0) == pytest.approx((46.0, 8.0), abs=1e-9)


class TestFilling:
    # A void of 2 x 2 in ground that rises to the north-east, and a void in a corner.
    GROUND = np.add.outer(np.arange(9, 0, -1), np.arange(9)) * 10.0

    def voided(self):
        heights = self.GROUND.astype(np.float32)
        heights[3:5, 3:5] = heights[8, 0] = -1
        return heights

    def test_only_voids_change(self, tif, write_tif):
        write_tif(self.voided(), nodata=-1)
        kept, filled = load(tif), load(tif, fill_voids=True)
        assert kept.voids.sum() == 5
        assert not filled.voids.any()
        np.testing.assert_array_equal(filled.elevation[~kept.voids], kept.elevation[~kept.voids])
        middle = filled.elevation[4:6, 3:5]
        np.testing.assert_allclose(middle, self.GROUND[::-1][4:6, 3:5], atol=10)

    def test_as_gdal_fills(self, write_tif):
        from rasterio.fill import fillnodata

        heights = self.voided()
        expected = fillnodata(
            heights.copy(),
            mask=(heights != -1).astype(np.uint8),
            max_search_distance=9,
            smoothing_iterations=0,
        )
        filled = load(write_tif(heights, nodata=-1), fill_voids=True)
        np.testing.assert_array_equal(filled.elevation, expected[::-1])

    def test_before_reprojection(self, tif, write_tif):
        write_tif(self.voided(), Affine(0.001, 0, 9, 0, -0.001, 46), "EPSG:4326", nodata=-1)
        assert load(tif).voids.any()
        assert not load(tif, fill_voids=True).voids.any()

    @pytest.mark.parametrize("suffix", [".npy", ".npz"])
    def test_of_our_own_files(self, tmp_path, write_tif, suffix):
        heights = np.where(self.voided() == -1, np.nan, self.voided())[::-1]
        file = tmp_path / f"made{suffix}"
        if suffix == ".npy":
            np.save(file, heights)
        else:
            np.savez(file, elevation=heights, dx_m=30, dy_m=30)
        filled = load(file, cell=(30, 30) if suffix == ".npy" else None, fill_voids=True)
        expected = load(write_tif(self.voided(), nodata=-1), fill_voids=True)
        np.testing.assert_array_equal(filled.elevation, expected.elevation)


class TestFormats:
    def test_ascii_grid(self, tmp_path):
        file = tmp_path / "grid.asc"
        file.write_text(
            "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 50\n"
            "NODATA_value -9999\n10 20 30\n40 -9999 60\n"
        )
        terrain = load(file)
        np.testing.assert_array_equal(terrain.elevation, [[40, np.nan, 60], [10, 20, 30]])
        assert (terrain.dx_m, terrain.dy_m) == (50.0, 50.0)
        assert terrain.crs is terrain.origin is None

    def test_hgt(self, tmp_path):
        file = tmp_path / "N46E008.hgt"
        row, column = np.indices((1201, 1201))
        heights = (3000 - row + 0 * column).astype(">i2")
        heights[600, 600] = -32768
        file.write_bytes(heights.tobytes())
        terrain = load(file)
        assert terrain.crs == "EPSG:32632"
        # Row 0 of the file is the parallel of 47 degrees, and each later row is 3 seconds further
        # south.
        for lat, lon in ((46.2, 8.4), (46.75, 8.9)):
            ground = terrain.ground(*terrain.to_local(lat, lon))
            assert ground == pytest.approx(3000 - (47 - lat) * 1200, abs=0.6)
        assert np.isnan(terrain.ground(*terrain.to_local(46.5, 8.5)))
        assert 2 <= terrain.voids.sum() <= 12

    @pytest.mark.parametrize(("driver", "name"), [("DTED", "tile.dt1"), ("USGSDEM", "tile.dem")])
    def test_dted_and_usgs_dem(self, tmp_path, driver, name):
        row, column = np.indices((1201, 1201))
        hgt = tmp_path / "N46E008.hgt"
        hgt.write_bytes((3000 - row + column // 8).astype(">i2").tobytes())
        rasterio.shutil.copy(hgt, tmp_path / name, driver=driver)
        terrain, expected = load(tmp_path / name), load(hgt)
        assert terrain.crs == expected.crs
        assert terrain.shape == expected.shape
        np.testing.assert_allclose(terrain.elevation, expected.elevation, atol=1e-3)

    def test_pixels_given_by_their_centres(self, tif, write_tif):
        write_tif(HEIGHTS)
        area = load(tif)
        write_tif(HEIGHTS)
        with rasterio.open(tif, "r+") as made:
            made.update_tags(AREA_OR_POINT="Point")
        point = load(tif)
        assert point.origin == area.origin

    def test_npz(self, tmp_path):
        file = tmp_path / "made.npz"
        np.savez(file, elevation=HEIGHTS.astype(np.int16), dx_m=30, dy_m=20.5)
        terrain = load(str(file))
        assert terrain.elevation.tolist() == HEIGHTS.tolist()
        assert (terrain.name, terrain.source) == ("made", str(file))
        assert (terrain.dx_m, terrain.dy_m, terrain.crs) == (30.0, 20.5, None)

    def test_npy(self, tmp_path):
        np.save(tmp_path / "made.npy", HEIGHTS)
        terrain = load(tmp_path / "made.npy", cell=(30, 20))
        assert terrain.elevation.tolist() == HEIGHTS.tolist()
        assert (terrain.dx_m, terrain.dy_m) == (30.0, 20.0)

    def test_picture_with_given_cells(self, tif, write_tif):
        write_tif(HEIGHTS, transform=Affine.identity(), crs=None)
        terrain = load(tif, cell=(10, 5))
        assert terrain.elevation.tolist() == SOUTH_FIRST
        assert (terrain.dx_m, terrain.dy_m, terrain.crs) == (10.0, 5.0, None)


class TestRefusals:
    def test_unknown_name(self):
        assert refusal("nowhere") == (
            "There is no terrain 'nowhere': neither a file nor one of "
            "jacksboro, canyon, river, large-canyon."
        )

    def test_unreadable(self, tif):
        tif.write_bytes(b"no raster")
        assert refusal(tif) == (
            f"{tif}: cannot be read as a raster of heights; give a GeoTIFF, an SRTM .hgt, another "
            "format that GDAL reads, or a .npy or .npz file."
        )

    def test_an_hgt_of_another_name(self, tmp_path):
        file = tmp_path / "mytile.hgt"
        np.zeros((1201, 1201), ">i2").tofile(file)
        assert refusal(file) == (
            f"{file}: an SRTM .hgt states its place only in its name, the south-west corner in "
            "degrees such as N46E008.hgt; name it so again, unlike 'mytile.hgt'."
        )

    def test_an_hgt_cut_short(self, tmp_path):
        file = tmp_path / "N46E008.hgt"
        file.write_bytes(bytes(2 * 1201 * 1201 - 2000))
        assert refusal(file) == (
            f"{file}: an SRTM .hgt of 1201 or 3601 points a side has 2,884,802 or 25,934,402 bytes,"
            " but this file has 2,882,802: it is cut short or no such tile; get it again."
        )

    @pytest.mark.parametrize("crs", ["EPSG:4978", 'LOCAL_CS["site",UNIT["metre",1]]'])
    def test_a_system_that_is_no_map(self, tif, write_tif, crs):
        write_tif(HEIGHTS, crs=crs)
        assert "is neither geographic nor projected, so it has no map; warp it first" in refusal(
            tif
        )

    def test_a_place_outside_its_system(self, tif, write_tif):
        write_tif(HEIGHTS, Affine(30, 0, 8e8, 0, -30, 5e9))
        assert "lies where its reference system EPSG:32632 is no map of the Earth" in refusal(tif)

    def test_folder(self, tmp_path):
        assert refusal(tmp_path) == (
            f"{tmp_path}: is a folder; give a file, and join several tiles first (gdalbuildvrt "
            f"ALL.vrt {tmp_path.name}/*.tif)."
        )

    def test_folder_without_a_name(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        assert refusal(Path()).endswith(f"(gdalbuildvrt ALL.vrt {tmp_path.name}/*.tif).")

    def test_all_void(self, tif, write_tif):
        write_tif(np.full((2, 3), -1, np.int16), nodata=-1)
        assert refusal(tif) == "made: every node is void; choose a terrain with heights."
        assert refusal(tif, fill_voids=True) == refusal(tif)

    def test_single_row(self, tif, write_tif):
        write_tif(HEIGHTS[:1], crs="EPSG:4326", transform=Affine(0.01, 0, 0, 0, -0.01, 0))
        assert refusal(tif) == "made: a terrain needs at least 2 x 2 nodes, but this one has 1 x 3."

    def test_bands(self, tif, write_tif):
        write_tif(np.stack((HEIGHTS, HEIGHTS)))
        assert refusal(tif) == (
            f"{tif}: a terrain has one band of heights, but this file has 2; "
            "write the band of heights to a separate file."
        )

    def test_complex(self, tif, write_tif):
        write_tif(HEIGHTS.astype(np.complex64))
        assert refusal(tif) == f"{tif}: heights must be real numbers, but the band holds complex64."

    def test_vertical_unit(self, tif, write_tif):
        write_tif(HEIGHTS, unit="fathom")
        assert refusal(tif) == (
            f"{tif}: its heights are in 'fathom', which is unknown; convert them to metres, or "
            "state their unit (--height-unit m|dm|cm|ft|us-ft)."
        )

    def test_rotated(self, tif, write_tif):
        write_tif(HEIGHTS, transform=Affine(29, 5, 0, 5, -29, 0))
        assert refusal(tif) == (
            "made: the raster is rotated against its coordinate axes; warp it "
            "to north up first, with gdalwarp for example."
        )

    def test_degrees_without_a_crs(self, tif, write_tif):
        write_tif(HEIGHTS, crs=None, transform=Affine(0.001, 0, 8, 0, -0.001, 46))
        assert refusal(tif) == (
            "made: cells of 0.001 x 0.001 without a coordinate reference system look like degrees; "
            "add the system to the file."
        )

    def test_raster_without_cells(self, tif, write_tif):
        write_tif(HEIGHTS, transform=Affine.identity(), crs=None)
        assert refusal(tif) == (
            "made: the file does not state the size of its cells; give it "
            "in metres (--cell DX[,DY])."
        )

    def test_needless_cell(self, write_tif, tmp_path):
        message = "the file states the size of its cells; leave it out (--cell)."
        assert refusal(write_tif(HEIGHTS), cell=(1, 1)) == f"made: {message}"
        file = tmp_path / "made.npz"
        np.savez(file, elevation=HEIGHTS, dx_m=1, dy_m=1)
        assert refusal(file, cell=(1, 1)) == f"{file}: {message}"
        assert refusal("canyon", cell=(1, 1)) == (
            "The terrain 'canyon' states the size of its cells; leave it out (--cell)."
        )

    @pytest.mark.parametrize(
        ("cell", "shown"),
        [
            ((0, 1), "0 x 1"),
            ((30, -30), "30 x -30"),
            ((np.nan, 1), "nan x 1"),
            ((1, np.inf), "1 x inf"),
        ],
    )
    def test_cell_not_positive(self, tmp_path, cell, shown):
        file = tmp_path / "made.npy"
        np.save(file, HEIGHTS)
        assert refusal(file, cell=cell) == (
            f"The sides of a cell must be positive metres, not {shown}."
        )

    def test_npy_without_cell(self, tmp_path):
        file = tmp_path / "made.npy"
        np.save(file, HEIGHTS)
        assert refusal(file) == (
            f"{file}: a .npy file does not state the size of its cells; give it in "
            "metres (--cell DX[,DY])."
        )

    @pytest.mark.parametrize("content", [b"", b"no numpy file"])
    def test_unreadable_npy(self, tmp_path, content):
        file = tmp_path / "made.npy"
        file.write_bytes(content)
        assert refusal(file, cell=(1, 1)) == (
            f"{file}: cannot be read as a numpy array; write it with numpy.save."
        )

    def test_unreadable_npz(self, tmp_path):
        file = tmp_path / "made.npz"
        message = f"{file}: cannot be read as a numpy archive; write it with numpy.savez."
        file.write_bytes(b"no archive")
        assert refusal(file) == message
        with file.open("wb") as array:
            np.save(array, HEIGHTS)
        assert refusal(file) == message
        np.savez(file, elevation=np.array([[object()] * 2] * 2), dx_m=1, dy_m=1)
        assert refusal(file) == message

    def test_npz_keys(self, tmp_path):
        file = tmp_path / "made.npz"
        np.savez(file, elevation=HEIGHTS, dx_m=1)
        assert refusal(file) == (
            f"{file}: there is no 'dy_m' in it; a terrain file holds elevation, dx_m, dy_m."
        )

    @pytest.mark.parametrize("side", [np.array([1.0, 2.0]), np.array("ten")])
    def test_npz_side_is_no_number(self, tmp_path, side):
        file = tmp_path / "made.npz"
        np.savez(file, elevation=HEIGHTS, dx_m=side, dy_m=1)
        assert refusal(file) == f"{file}: 'dx_m' must be one number of metres."

    @pytest.mark.parametrize(
        "place",
        [
            {"crs": "EPSG:32632"},
            {"origin": [500_000, 5_100_000]},
            {"crs": 32632, "origin": [500_000, 5_100_000]},
            {"crs": "EPSG:32632", "origin": [500_000]},
            {"crs": "EPSG:32632", "origin": ["east", "north"]},
            {"crs": "EPSG:32632", "origin": [np.nan, 5_100_000]},
        ],
    )
    def test_npz_place_is_bad(self, tmp_path, place):
        file = tmp_path / "made.npz"
        np.savez(file, elevation=HEIGHTS, dx_m=1, dy_m=1, **place)
        assert refusal(file) == (
            f"{file}: 'crs' must be the name of a reference system and 'origin' the easting and "
            "northing of the south-west node in it; write both or neither."
        )

    def test_npz_is_checked_as_any_terrain(self, tmp_path):
        file = tmp_path / "made.npz"
        np.savez(file, elevation=HEIGHTS, dx_m=1, dy_m=0)
        assert refusal(file) == (
            f"{file}: the sides of a cell must be positive metres, but dy_m is 0."
        )
        np.savez(file, elevation=HEIGHTS[0], dx_m=1, dy_m=1)
        assert refusal(file) == (
            f"{file}: the heights must be a grid of rows and columns, but have 1 dimensions."
        )

    def test_undeclared_voids_are_no_heights(self, tmp_path):
        heights = np.array([[1, -32768, 3], [4, 5, 6]], dtype=np.int16)
        np.save(tmp_path / "made.npy", heights)
        np.savez(tmp_path / "made.npz", elevation=heights, dx_m=10, dy_m=10)
        for terrain in (
            load(tmp_path / "made.npy", cell=(10.0, 10.0)),
            load(tmp_path / "made.npz"),
        ):
            assert terrain.voids.tolist() == [[False, True, False], [False] * 3]
            assert (terrain.lowest, terrain.highest) == (1.0, 6.0)
