import numpy as np
import pytest
import rasterio

from pathgene.host.errors import InputError
from pathgene.host.terrain import raster


@pytest.mark.parametrize("declared", [-32767, -9999, None])
def test_undeclared_marks_of_voids_are_voids(tmp_path, declared):
    heights = np.full((3, 4), 100, np.int16)
    heights[1, 2] = -32768
    with rasterio.open(
        tmp_path / "t.tif",
        "w",
        driver="GTiff",
        height=3,
        width=4,
        count=1,
        dtype="int16",
        crs="EPSG:32632",
        nodata=declared,
        transform=rasterio.Affine(30, 0, 500_000, 0, -30, 5_000_000),
    ) as file:
        file.write(heights, 1)
    read = raster.read(tmp_path / "t.tif").heights
    assert np.argwhere(np.isnan(read)).tolist() == [[1, 2]]
    assert np.nanmin(read) == np.nanmax(read) == 100


@pytest.mark.parametrize(("scale", "offset"), [(0.0, 0.0), (np.nan, 0.0), (1.0, np.inf)])
def test_a_scale_that_makes_all_heights_equal_is_refused(tmp_path, scale, offset):
    with rasterio.open(
        tmp_path / "t.tif",
        "w",
        driver="GTiff",
        height=3,
        width=4,
        count=1,
        dtype="int16",
        crs="EPSG:32632",
        transform=rasterio.Affine(30, 0, 500_000, 0, -30, 5_000_000),
    ) as file:
        file.write(np.full((3, 4), 100, np.int16), 1)
        file.scales, file.offsets = (scale,), (offset,)
    with pytest.raises(InputError, match=r"t\.tif: its scale, .* turn all cells into one height"):
        raster.read(tmp_path / "t.tif")
