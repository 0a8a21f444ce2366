"""Terrains beyond all places on Earth, and heights beyond all numbers of metres."""

import contextlib

import numpy as np
import pytest
from affine import Affine

from pathgene.host.errors import InputError
from pathgene.host.terrain import load


@pytest.mark.parametrize("crs", [None, "EPSG:32632", "EPSG:4326", "EPSG:3857"])
@pytest.mark.parametrize(("side", "east"), [(1e308, 0.0), (100.0, 1e308), (1e12, 0.0)])
def test_a_raster_beyond_all_maps_is_refused(write_tif, crs, side, east):
    """Some projections of such places never end, and some have no inverse."""
    file = write_tif(np.full((4, 5), 100.0), Affine(side, 0, east, 0, -side, 0), crs)
    with pytest.raises(InputError, match=r"no place on Earth is beyond 1e\+11; check the corner"):
        load(file)


@pytest.mark.parametrize("place", [{}, {"crs": "EPSG:3857", "origin": (0.0, 0.0)}])
def test_an_archive_beyond_all_maps_is_refused(tmp_path, place):
    file = tmp_path / "t.npz"
    np.savez(file, elevation=np.full((4, 5), 100.0), dx_m=1e308, dy_m=30.0, **place)
    with pytest.raises(InputError, match=r"5 nodes at 1e\+308 m are a map of inf m"):
        load(file)


@pytest.mark.parametrize("height", [1e308, -1e308])
@pytest.mark.parametrize("cells", [1, 2, 10, 20])
def test_heights_of_1e308_are_voids_or_refused(write_tif, height, cells):
    heights = np.full(20, 100.0)
    heights[:cells] = height
    file = write_tif(heights.reshape(4, 5), Affine(30, 0, 500_000, 0, -30, 5_100_000))
    with contextlib.suppress(InputError):
        assert load(file).highest <= 100
