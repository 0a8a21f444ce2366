"""Heights far from all other heights: cliffs, islands and fjords are ground, numbers are not."""

from pathlib import Path

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.terrain import load
from pathgene.host.terrain.gaps import far_groups, joins
from pathgene.host.terrain.stated import Stated


TILES = sorted((Path(__file__).parents[4] / "shared" / "terrain").glob("*.tif"))


def cell(write_tif, heights, side_m, **profile):
    from affine import Affine

    heights = np.asarray(heights, np.float32)
    return write_tif(heights, Affine(side_m, 0, 500_000, 0, -side_m, 5_100_000), **profile)


def volcano(side_m, *, foot=1_050.0, top=3_700.0):
    """Return sea with a volcano whose lowest cell on land is ``foot`` metres high."""
    y, x = (np.indices((40, 40)) - 20) * side_m
    height = top * (1 - np.hypot(x, y) / (12 * side_m))
    return np.where(height > foot, height, 0.0)


def fjord(side_m):
    """Return a channel of sea in a plateau of 1,500 to 1,700 m, with walls of one cell."""
    rng = np.random.default_rng(1)
    heights = rng.uniform(1_500, 1_700, (40, 40))
    heights[:, 15:22] = 0.0
    heights[:, [14, 22]] = rng.uniform(1_050, 1_300, (40, 2))
    return heights


@pytest.mark.parametrize("land", [volcano, fjord])
@pytest.mark.parametrize("side_m", [900.0, 2_000.0, 10_000.0])
def test_coarse_cells_skip_heights(write_tif, land, side_m):
    heights = land(side_m)
    assert far_groups(heights)
    terrain = load(cell(write_tif, heights, side_m))
    assert not terrain.voids.any()
    assert terrain.lowest == 0.0
    assert not terrain.reading.warnings


@pytest.mark.parametrize("land", [volcano, fjord])
def test_the_same_heights_in_fine_cells_are_no_ground(write_tif, land):
    """A step of 1,050 m on a side of 100 m, all around the sea, is not land."""
    terrain = load(cell(write_tif, land(100.0), 100.0))
    assert (terrain.voids[::-1] == (land(100.0) == 0)).all()


@pytest.mark.parametrize("side_m", [1.0, 30.0, 90.0, 500.0])
def test_a_volcano_down_to_the_sea(write_tif, side_m):
    heights = volcano(side_m, foot=0.0)
    terrain = load(cell(write_tif, heights, side_m))
    assert not terrain.voids.any()


def test_a_cliff_that_ends_somewhere(write_tif):
    """A wall of 1,400 m in one cell of 30 m, with a slope beside it."""
    heights = np.where(np.arange(60) < 30, 200.0, 1_600.0) * np.ones((60, 1))
    heights[55:] = np.linspace(200, 1_600, 60)
    assert not load(cell(write_tif, heights, 30.0)).voids.any()


def test_a_summit_amid_voids(write_tif):
    """A ring of voids hides the slopes between plain and summit."""
    y, x = np.indices((100, 100)) - 50
    far = np.hypot(x, y)
    heights = np.where(far > 40, 500.0 + x, 3_500.0 - 20 * far)
    heights[(far > 10) & (far <= 40)] = -9999
    terrain = load(cell(write_tif, heights, 90.0, nodata=-9999))
    assert (terrain.voids[::-1] == (heights == -9999)).all()
    assert terrain.highest == 3_500
    # The same voids as numbers that stand in a plain, with a seam of one void around them.
    heights = np.where(far > 40, 500.0 + x, 3_500.0 - 0.1 * far)
    heights[(far > 39) & (far <= 40)] = -9999
    with pytest.raises(InputError, match=r"more than 1,000 m from all other heights, with no grou"):
        load(cell(write_tif, heights, 30.0, nodata=-9999))


def test_a_plain_of_one_height(write_tif):
    """The ground itself may have a single height."""
    heights = np.full((20, 20), 100.0)
    heights[3:6, 4:9] = 5_000.0
    terrain = load(cell(write_tif, heights, 30.0))
    assert terrain.voids.sum() == 15
    assert terrain.highest == 100.0


def test_a_gap_between_neighbouring_classes():
    """Classes that touch a gap belong to one group if their heights are near enough."""
    ground = np.arange(2_000.0, 2_090.0)
    for lowest, groups in ((999.0, [(999.0, 999.0, 20)]), (1_001.0, [])):
        found = far_groups(np.tile([lowest, *ground], (20, 1)))
        assert [(each.bottom, each.top, each.cells) for each in found] == groups


def test_an_area_without_neighbours_joins():
    heights = np.full((4, 4), np.nan)
    heights[1, 1] = 5.0
    assert joins(heights, heights == 5.0, 30.0)


@pytest.mark.parametrize("file", TILES, ids=lambda file: file.stem)
@pytest.mark.parametrize("every", [1, 4, 16])
def test_real_tiles(write_tif, file, every):
    """Real land has no such heights, also in coarse cells."""
    import rasterio

    with rasterio.open(file) as opened:
        heights = opened.read(1)[::every, ::every]
        terrain = load(
            write_tif(
                heights,
                opened.transform @ rasterio.Affine.scale(every),
                opened.crs,
                nodata=opened.nodata,
            )
        )
    assert not terrain.reading.facts["voids"]["marks"]
    assert [text for text in terrain.reading.warnings if "datum" not in text] == []
    accepted = load(write_tif(heights, opened.transform, opened.crs), stated=Stated(void="none"))
    assert accepted.shape
