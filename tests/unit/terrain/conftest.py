"""Raster files for tests."""

import warnings

import numpy as np
import pytest
import rasterio
from affine import Affine


@pytest.fixture
def write_tif(tmp_path):
    """Function that writes heights, rows from the north, to ``made.tif`` and returns its path."""

    def write(heights, transform=None, crs="EPSG:32632", *, unit=None, **profile):
        heights = np.asarray(heights)
        bands = heights if heights.ndim == 3 else heights[np.newaxis]
        count, rows, columns = bands.shape
        transform = transform or Affine(30, 0, 500_000, 0, -30, 5_100_000)
        file = tmp_path / "made.tif"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)
            with rasterio.open(
                file,
                "w",
                driver="GTiff",
                height=rows,
                width=columns,
                count=count,
                dtype=heights.dtype,
                crs=crs,
                transform=transform,
                **profile,
            ) as made:
                made.write(bands)
                if unit is not None:
                    made.units = (unit,)
        return file

    return write
