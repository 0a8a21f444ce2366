"""Virtual rasters: their files are checked before GDAL opens them."""

import os
from xml.sax.saxutils import unescape

import numpy as np
import pytest
import rasterio

from pathgene.host.errors import InputError
from pathgene.host.terrain import load


RASTER = (
    '<VRTDataset rasterXSize="20" rasterYSize="20">'
    "<GeoTransform>0,10,0,0,0,-10</GeoTransform>"
    '<VRTRasterBand dataType="Float64" band="1"><SimpleSource>'
    '<SourceFilename relativeToVRT="{relative}">{name}</SourceFilename><SourceBand>1</SourceBand>'
    '<SrcRect xOff="0" yOff="0" xSize="20" ySize="20"/>'
    '<DstRect xOff="0" yOff="0" xSize="20" ySize="20"/>'
    "</SimpleSource></VRTRasterBand></VRTDataset>"
)


@pytest.fixture
def virtual(tmp_path):
    """Function that writes a virtual raster of a source; its file name gives no hint."""

    def write(name, *, relative=1, file="made.tif"):
        path = tmp_path / file
        path.write_text(RASTER.format(name=name, relative=relative))
        return path

    return write


def refusal(file):
    with pytest.raises(InputError) as error:
        load(file)
    return str(error.value)


def write_tif(file, **options):
    """Write a raster of 20 x 20 heights without writing its blocks."""
    with rasterio.open(
        file, "w", driver="GTiff", width=20, height=20, count=1, dtype="float64", SPARSE_OK=True,
        transform=rasterio.transform.from_origin(0, 0, 10, 10), **options,
    ) as made:  # fmt: skip
        if not options:
            made.write(np.arange(400.0).reshape(1, 20, 20))


def test_reads_a_virtual_raster(virtual, tmp_path):
    write_tif(tmp_path / "source.tif")
    assert load(virtual("source.tif")).highest == 399
    assert load(virtual(tmp_path / "source.tif", relative=0)).highest == 399


@pytest.mark.parametrize("name", ["fifo", "nested.vrt"])
def test_a_fifo_is_not_waited_for(virtual, tmp_path, name):
    os.mkfifo(tmp_path / "fifo")
    virtual("fifo", file="nested.vrt")
    assert refusal(virtual(name)) == (
        f"{tmp_path / 'fifo'}: must be a regular file, not a pipe or a device; copy it into one."
    )


@pytest.mark.parametrize("beside", ["x.tif.aux.xml", "x.tif.msk", "x.prj"])
def test_a_fifo_beside_a_raster_is_not_waited_for(virtual, tmp_path, beside):
    write_tif(tmp_path / "x.tif")
    os.mkfifo(tmp_path / "xy.fifo")
    assert load(virtual("x.tif")).highest == 399
    os.mkfifo(tmp_path / beside)
    for file in (tmp_path / "x.tif", virtual("x.tif")):
        assert refusal(file) == (
            f"{tmp_path / beside}: belongs to the raster x.tif by its name, and is a pipe or a "
            "device; remove it or copy it into a regular file."
        )


def test_a_fifo_in_a_folder_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "hdr.adf")
    assert refusal(tmp_path).startswith(f"{tmp_path / 'hdr.adf'}: belongs to the raster ")


def test_a_chain_of_virtual_rasters(virtual, tmp_path):
    write_tif(tmp_path / "0.vrt")
    for number in range(1, 1500):
        virtual(f"{number - 1}.vrt", file=f"{number}.vrt")
    assert load(tmp_path / "30.vrt").highest == 399
    assert "is nested in more than 50 virtual rasters" in refusal(tmp_path / "1499.vrt")


def test_a_source_of_huge_blocks(virtual, tmp_path):
    """The file has 266 bytes and declares 400 cells in one block of 34 GB."""
    source = tmp_path / "source.tif"
    write_tif(source, tiled=True, blockxsize=65536, blockysize=65536, compress="deflate")
    sentence = (
        f"{source}: is stored in blocks of 65536 x 65536 cells, more than 25,000,000; write it "
        "again with smaller ones, with gdal_translate for example."
    )
    assert refusal(source) == sentence
    assert refusal(virtual("source.tif")) == sentence


# Names with which GDAL would find the FIFO, or anything else that is not a file.
NAMES = (
    "/vsisubfile/0_1000,{folder}/fifo",
    "/vsizip/{folder}/fifo",
    "/vsicurl/http://127.0.0.1:9/a.tif",
    "vrt://{folder}/fifo?bands=1",
    "GTIFF_DIR:1:{folder}/fifo",
    "a:/fifo",
    "&lt;VRTDataset>&lt;/VRTDataset>",
    "nowhere.tif",
    "a&amp;b",
    "",
    ".",
    "\\fifo",
)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("relative", [0, 1])
def test_names_that_are_no_files(virtual, tmp_path, name, relative):
    os.mkfifo(tmp_path / "fifo")
    name = name.format(folder=tmp_path)
    file = virtual(name, relative=relative)
    assert refusal(file) == (
        f"{file}: names the source {unescape(name)!r}, which is not a file; a virtual raster may "
        "be made of files only, so name one, or give its heights as a GeoTIFF."
    )


@pytest.mark.parametrize(
    "element",
    [
        "<sourcefilename>{fifo}</sourcefilename>",
        "<SimpleSource SourceFilename='{fifo}'/>",
        "<SourceDataset xmlns='urn:x'>{fifo}</SourceDataset>",
        "<SourceFilename><a/>{fifo}</SourceFilename>",
        "<DEMPath>{fifo}</DEMPath>",
        "<MDI key='X_DATASET'>{fifo}</MDI>",
        "<MDI key='OVERVIEW_FILE'>{fifo}</MDI>",
        "<Argument name='gain_dataset_filename_1'>{fifo}</Argument>",
    ],
)
def test_a_fifo_is_found_wherever_gdal_reads_a_name(tmp_path, element):
    fifo, file = tmp_path / "fifo", tmp_path / "made.vrt"
    os.mkfifo(fifo)
    file.write_text(f"<VRTDataset>{element.format(fifo=fifo)}</VRTDataset>")
    assert refusal(file) == (
        f"{fifo}: must be a regular file, not a pipe or a device; copy it into one."
    )


@pytest.mark.parametrize("name", ["made.tif", "<"])
def test_damaged_virtual_rasters(virtual, name):
    file = virtual(name)
    assert refusal(file).startswith(f"{file}: cannot be read as a raster of heights; ")
