import numpy as np
import pytest
import rasterio

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
