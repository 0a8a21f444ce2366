"""The terrains of a desk."""

import io

import numpy as np
import pytest
import rasterio
from affine import Affine

from pathgene.host.errors import InputError
from pathgene.host.mission.build import terrain_of
from pathgene.host.terrain import embedded
from pathgene.host.web.desk.terrains import Terrains


def npz(rows=20, columns=30):
    content = io.BytesIO()
    np.savez(content, elevation=np.zeros((rows, columns)), dx_m=10.0, dy_m=10.0)
    return content.getvalue()


def test_the_same_content_has_the_same_name_after_a_restart(tmp_path):
    terrains = Terrains(tmp_path)
    name = terrains.add_content("../my tile!.NPZ", npz(), {})
    assert name.startswith("my-tile-")
    assert name.endswith(".npz")
    assert terrains.add_content("../my tile!.NPZ", npz(), {}) == name
    later = Terrains(tmp_path)
    assert later.names == [*embedded.names(), name]
    assert later.load({"terrain": name}).shape == (20, 30)


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("a.npz", b"PK", "a.npz: cannot be read as a numpy archive; write it with numpy.savez."),
        ("a.npz", npz(200, 300), "a.npz: its 200 x 300 cells are more than 10,000; cut it, make "),
        ("a.tif", b"no raster", "a.tif: "),
        ("a", b"", "a: "),
    ],
)
def test_what_is_no_terrain_leaves_no_file(tmp_path, name, content, sentence):
    terrains = Terrains(tmp_path / "kept", max_cells=10_000)
    with pytest.raises(InputError) as caught:
        terrains.add_content(name, content, {})
    assert sentence in str(caught.value)
    assert str(tmp_path) not in str(caught.value)
    assert list((tmp_path / "kept").iterdir()) == []
    assert terrains.names == [*embedded.names()]


def test_a_file_never_takes_the_name_of_another(tmp_path):
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "land.npz").write_bytes(npz())
    (tmp_path / "canyon").write_bytes(npz())
    terrains = Terrains(tmp_path / "none")
    first = terrains.add_file(tmp_path / "one" / "land.npz")
    assert first == "land.npz"
    assert terrains.add_file(tmp_path / "two" / "land.npz") == "land-2.npz"
    assert terrains.add_file(tmp_path / "one" / "land.npz") == first
    assert terrains.add_file(tmp_path / "canyon") == "canyon-2"


def test_few_terrains_stay_in_memory(tmp_path):
    terrains = Terrains(tmp_path)
    names = [terrains.add_content(f"{n}.npz", npz(20 + n), {}) for n in range(6)]
    loaded = [terrains.load({"terrain": name}) for name in names]
    assert terrains.load({"terrain": names[-1]}) is loaded[-1]
    assert terrains.load({"terrain": names[0]}) is not loaded[0]


def test_content_that_names_files_is_refused_also_after_a_restart(tmp_path):
    land = tmp_path / "land.tif"
    with rasterio.open(
        land, "w", driver="GTiff", width=20, height=20, count=1, dtype="int16", crs="EPSG:32616",
        transform=Affine(10, 0, 5e5, 0, -10, 4e6),
    ) as written:  # fmt: skip
        written.write(np.zeros((1, 20, 20), "int16"))
    virtual = (
        '<VRTDataset rasterXSize="20" rasterYSize="20"><SRS>EPSG:32616</SRS><GeoTransform>500000, '
        '10, 0, 4000000, 0, -10</GeoTransform><VRTRasterBand dataType="Int16" band="1">'
        f"<SimpleSource><SourceFilename>{land}</SourceFilename></SimpleSource></VRTRasterBand>"
        "</VRTDataset>"
    ).encode()
    terrains = Terrains(tmp_path / "kept")
    for name in ("a.vrt", "a.tif"):
        with pytest.raises(InputError, match=f"^{name}: cannot be read as a raster that holds "):
            terrains.add_content(name, virtual, {})
    assert list((tmp_path / "kept").iterdir()) == []
    # Content that was taken earlier; the process of a plan loads it, too.
    (tmp_path / "kept" / "old.vrt").write_bytes(virtual)
    later = Terrains(tmp_path / "kept")
    with pytest.raises(InputError, match="cannot be read as a raster that holds "):
        later.load({"terrain": "old.vrt"})
    with pytest.raises(InputError, match="cannot be read as a raster that holds "):
        terrain_of(later.task("old.vrt"))
    # A file that the user named.
    (tmp_path / "mine.vrt").write_bytes(virtual)
    name = later.add_file(tmp_path / "mine.vrt")
    assert later.load({"terrain": name}).shape == (20, 20)
    assert terrain_of(later.task(name)).shape == (20, 20)


def test_a_tile_of_srtm_keeps_its_place(tmp_path):
    """GDAL takes the place of a tile from the name of its file."""
    tile = np.full((1201, 1201), 300, ">i2").tobytes()
    terrains = Terrains(tmp_path)
    name = terrains.add_content("N36W085.hgt", tile, {})
    corner = terrains.load({"terrain": name}).to_geographic([0.0], [0.0])
    assert [float(each[0]) for each in corner] == pytest.approx([36, -85], abs=0.02)


def test_a_problem_without_a_terrain_is_one_sentence(tmp_path):
    with pytest.raises(InputError, match=r"^The problem names no terrain; choose one\.$"):
        Terrains(tmp_path).load({})
