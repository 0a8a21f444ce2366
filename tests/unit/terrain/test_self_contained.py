"""Terrain files from third parties do not open further files."""

import warnings

import numpy as np
import pytest
import rasterio
from affine import Affine
from rasterio.errors import NotGeoreferencedWarning

from pathgene.host.errors import InputError
from pathgene.host.terrain import load
from pathgene.host.terrain.stated import Stated


PLACE = Affine(10, 0, 500_000, 0, -10, 4_000_000)
# UTM zone 16 with a file of corrections, which PROJ opens.
GRIDS = "+proj=utm +zone=16 +ellps=clrk66 +nadgrids={} +units=m"


def raster(file, crs="EPSG:32616", driver="GTiff", **tags):
    heights = np.arange(400, dtype="int16").reshape(1, 20, 20)
    with rasterio.open(
        file,
        "w",
        driver=driver,
        width=20,
        height=20,
        count=1,
        dtype="int16",
        transform=PLACE,
        crs=crs,
    ) as written:
        written.write(heights)
        for space, values in tags.items():
            written.update_tags(ns=space, **values)
    return heights[0]


@pytest.fixture
def secret(tmp_path):
    """A raster on the machine."""
    (tmp_path / "home").mkdir()
    file = tmp_path / "home" / "secret.tif"
    raster(file)
    return file


def vrt(secret):
    return f"""<VRTDataset rasterXSize="20" rasterYSize="20">
      <SRS>EPSG:32616</SRS><GeoTransform>500000, 10, 0, 4000000, 0, -10</GeoTransform>
      <VRTRasterBand dataType="Int16" band="1"><SimpleSource>
      <SourceFilename>{secret}</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>"""


def wms(secret):
    return f"""<GDAL_WMS><Service name="TMS"><ServerUrl>file://{secret}</ServerUrl></Service>
      <DataWindow><UpperLeftX>500000</UpperLeftX><UpperLeftY>4000000</UpperLeftY>
      <LowerRightX>500200</LowerRightX><LowerRightY>3999800</LowerRightY>
      <SizeX>20</SizeX><SizeY>20</SizeY><TileLevel>0</TileLevel></DataWindow>
      <BlockSizeX>20</BlockSizeX><BlockSizeY>20</BlockSizeY>
      <Projection>EPSG:32616</Projection><BandsCount>1</BandsCount></GDAL_WMS>"""


def mrf(secret):
    return f"""<MRF_META><Raster><Size x="20" y="20" c="1"/><PageSize x="20" y="20" c="1"/>
      <Compression>NONE</Compression><DataType>Int16</DataType><DataFile>{secret}</DataFile>
      <IndexFile>{secret}</IndexFile></Raster><GeoTags><BoundingBox minx="500000" miny="3999800"
      maxx="500200" maxy="4000000"/><Projection>EPSG:32616</Projection></GeoTags></MRF_META>"""


@pytest.mark.parametrize("name", ["a.vrt", "a.tif", "a.xml", "a.asc", "N36W085.hgt", "a.kml", "a"])
@pytest.mark.parametrize("content", [vrt, wms, mrf])
def test_files_that_name_others_are_refused_whatever_their_name(tmp_path, secret, content, name):
    file = tmp_path / name
    file.write_text(content(secret))
    if content is vrt:
        # The user's own files may do so.
        assert load(file).shape == (20, 20)
    with pytest.raises(InputError) as caught:
        load(file, self_contained=True)
    assert str(caught.value) == (
        f"{file}: cannot be read as a raster that holds its heights itself; give a GeoTIFF, an "
        "SRTM .hgt, an ASCII grid, or a .npy or .npz file. A format that names other files, such "
        "as VRT, is converted with gdal_translate, or named when the desk is started."
    )


def test_a_virtual_raster_inside_another_format_is_not_opened(tmp_path, secret):
    """GDAL takes a file for virtual by a word in its first bytes."""
    file = tmp_path / "a.asc"
    cells = "\n".join(" ".join(["7"] * 20) for _ in range(20))
    text = f"ncols 20\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 10\n{cells}\n"
    file.write_text(text + vrt(secret))
    assert (load(file, self_contained=True).elevation == 7).all()


def test_overviews_in_another_file_are_refused(tmp_path, secret):
    file = tmp_path / "a.tif"
    raster(file, OVERVIEWS={"OVERVIEW_FILE": str(secret)})
    with rasterio.open(file) as opened:
        assert str(secret) in opened.files
    with pytest.raises(InputError, match=r": names a file of overviews; write it again without, "):
        load(file, self_contained=True)


@pytest.mark.parametrize(
    "crs", [GRIDS.format("/elsewhere/user/secret"), GRIDS.format("secret,@null")]
)
def test_reference_systems_that_name_files_are_refused(tmp_path, crs):
    with rasterio.Env():
        raster(tmp_path / "a.tif", crs)
        wkt = rasterio.crs.CRS.from_string(crs).to_wkt()
    cells = {"elevation": np.zeros((20, 20)), "dx_m": 10.0, "dy_m": 10.0, "origin": (5e5, 4e6)}
    files = [tmp_path / "a.tif"]
    for number, text in enumerate([crs, wkt, "/etc/passwd", "+init=/etc/x:1", "http://x.invalid/"]):
        files.append(tmp_path / f"{number}.npz")
        np.savez(files[-1], crs=text, **cells)
    for file in files:
        with pytest.raises(InputError) as caught:
            load(file, self_contained=True)
        assert str(caught.value) == (
            f"{file}: its reference system names a file; write the terrain again in a system with "
            "an EPSG code, with gdalwarp for example."
        )


@pytest.mark.parametrize("crs", ["EPSG:32616", "EPSG:32716", "EPSG:26716", "EPSG:2136"])
def test_what_holds_its_heights_itself_loads_as_ever(tmp_path, crs):
    files = [(tmp_path / "a.tif", "GTiff"), (tmp_path / "a.asc", "AAIGrid")]
    for file, driver in files:
        heights = raster(file, crs, driver)
        metres = Stated("m")
        alone = load(file, self_contained=True, stated=metres)
        before = load(file, stated=metres)
        np.testing.assert_array_equal(alone.elevation, heights[::-1])
        assert (alone.dx_m, alone.dy_m) == (before.dx_m, before.dy_m)
        assert alone.crs == before.crs
    with rasterio.open(files[0][0]) as opened:
        wkt = opened.crs.to_wkt()
    for number, text in enumerate((crs, wkt)):
        file = tmp_path / f"{number}.npz"
        np.savez(
            file, elevation=np.zeros((20, 20)), dx_m=10.0, dy_m=10.0, crs=text, origin=(5e5, 4e6)
        )
        assert load(file, self_contained=True).crs == load(file).crs


def test_a_tile_of_srtm_loads(tmp_path):
    file = tmp_path / "N36W085.1a2b3c4d.hgt"
    np.arange(1201 * 1201).reshape(1201, 1201).clip(0, 900).astype(">i2").tofile(file)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NotGeoreferencedWarning)
        np.testing.assert_array_equal(
            load(file, self_contained=True).elevation, load(file).elevation
        )
