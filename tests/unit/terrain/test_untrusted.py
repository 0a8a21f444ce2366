"""Terrain files that would exhaust memory or time: they are refused before they are read."""

import io
import os
import re
import resource
import zipfile

import numpy as np
import pytest
import rasterio

from pathgene.host.errors import InputError
from pathgene.host.terrain import load


def header(shape, kind="<f8"):
    """Return the beginning of a ``.npy`` file that states a shape."""
    made = io.BytesIO()
    stated = {"descr": kind, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_2_0(made, stated)
    return made.getvalue()


def archive(file, elevation, *, compression=zipfile.ZIP_DEFLATED, **others):
    """Write an ``.npz`` of the bytes of ``elevation`` and arrays."""
    with zipfile.ZipFile(file, "w", compression) as made:
        made.writestr("elevation.npy", elevation)
        for key, value in ({"dx_m": 30.0, "dy_m": 30.0} | others).items():
            member = io.BytesIO()
            np.save(member, value)
            made.writestr(f"{key}.npy", member.getvalue())
    return file


def refusal(source, **options):
    with pytest.raises(InputError) as error:
        load(source, **options)
    return str(error.value)


def test_a_sparse_tiff(tmp_path):
    file = tmp_path / "sparse.tif"
    with rasterio.open(
        file, "w", driver="GTiff", width=32_000, height=32_000, count=1, dtype="float32",
        SPARSE_OK=True, tiled=True, compress="deflate", crs="EPSG:32611",
        transform=rasterio.transform.from_origin(0, 0, 10, 10),
    ):  # fmt: skip
        pass
    assert refusal(file) == (
        f"{file}: its 32000 x 32000 cells are more than 25,000,000; cut it, make it coarser, or "
        "allow more (--max-cells)."
    )


def test_an_ascii_grid(tmp_path):
    file = tmp_path / "x.asc"
    corner = "xllcorner 0\nyllcorner 0\ncellsize 10\n1 2 3\n"
    file.write_text(f"ncols 100000\nnrows 100000\n{corner}")
    assert "100000 x 100000 cells are more than" in refusal(file)


def test_arrays_are_refused_by_their_headers(tmp_path):
    file = tmp_path / "x.npy"
    file.write_bytes(header((40_000, 40_000)) + bytes(100))
    assert "40000 x 40000 cells are more than" in refusal(file, cell=(30, 30))
    assert "40000 x 40000 cells" in refusal(archive(tmp_path / "x.npz", header((40_000, 40_000))))
    file.write_bytes(header((2, 2), "<U100000000") + bytes(100))
    assert refusal(file, cell=(30, 30)).endswith("write it with numpy.save.")


def test_a_header_may_lie_about_its_length(tmp_path):
    """A member of 4 GB of zeros takes a few megabytes in the archive, and no memory here."""
    stated = b"\x93NUMPY\x02\x00" + (4_000_000_000).to_bytes(4, "little")
    file = tmp_path / "x.npy"
    with file.open("wb") as sparse:
        sparse.write(stated)
        sparse.truncate(4_000_000_100)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert refusal(file, cell=(30, 30)).endswith("write it with numpy.save.")
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000


@pytest.mark.parametrize("shape", [(-3, 3), (-3, -3), (0, 10**30), (3, "3")])
def test_impossible_shapes(tmp_path, shape):
    file = tmp_path / "x.npy"
    file.write_bytes(header(shape) + bytes(100))
    assert refusal(file, cell=(30, 30)).endswith("write it with numpy.save.")


@pytest.mark.parametrize("compression", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_a_compression_that_numpy_never_uses(tmp_path, compression):
    file = tmp_path / "x.npz"
    elevation = io.BytesIO()
    np.save(elevation, np.zeros((3, 3)))
    archive(file, elevation.getvalue(), compression=compression)
    assert refusal(file).endswith("cannot be read as a numpy archive; write it with numpy.savez.")


def test_an_encrypted_archive(tmp_path):
    """The module zipfile cannot write one, but asks for a password if a member's flag is set."""
    file = tmp_path / "x.npz"
    elevation = io.BytesIO()
    np.save(elevation, np.zeros((3, 3)))
    content = bytearray(archive(file, elevation.getvalue()).read_bytes())
    # The flags are 6 bytes after the signature of a local header, 8 after a central one's.
    for signature, at in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        places = [found.start() for found in re.finditer(re.escape(signature), content)]
        assert len(places) == 3
        for place in places:
            content[place + at] |= 1
    file.write_bytes(content)
    with zipfile.ZipFile(file) as opened, pytest.raises(RuntimeError, match="encrypted"):
        opened.read("elevation.npy")
    assert refusal(file) == (
        f"{file}: cannot be read as a numpy archive; write it with numpy.savez."
    )


def test_other_members_are_as_small_as_they_should_be(tmp_path):
    elevation = io.BytesIO()
    np.save(elevation, np.zeros((3, 3)))
    file = archive(tmp_path / "x.npz", elevation.getvalue(), dx_m=np.zeros(1_000_000))
    assert refusal(file).endswith("cannot be read as a numpy archive; write it with numpy.savez.")


def test_the_limit_can_be_raised_and_lowered(tmp_path):
    file = tmp_path / "x.npy"
    np.save(file, np.zeros((30, 20)))
    assert load(file, cell=(30, 30), max_cells=600).elevation.shape == (30, 20)
    assert "30 x 20 cells are more than 599" in refusal(file, cell=(30, 30), max_cells=599)
    assert refusal(file, cell=(30, 30), max_cells=0) == (
        "A terrain must be allowed 1 cell or more, not 0."
    )


@pytest.mark.parametrize("name", ["pipe.tif", "pipe.npz", "pipe.npy"])
def test_a_pipe_is_not_waited_for(tmp_path, name):
    os.mkfifo(tmp_path / name)
    assert refusal(tmp_path / name, cell=(30, 30)).endswith(
        "must be a regular file, not a pipe or a device; copy it into one."
    )


def test_damaged_archives(tmp_path):
    """Cut anywhere or with any byte changed, they give an error, or a terrain for unused bytes."""
    elevation = io.BytesIO()
    np.save(elevation, np.arange(9.0).reshape(3, 3))
    file = archive(tmp_path / "x.npz", elevation.getvalue())
    whole = file.read_bytes()
    said = set()
    for place in range(len(whole)):
        for damaged in (
            whole[:place],
            whole[:place] + bytes([whole[place] ^ 1 << place % 8]) + whole[place + 1 :],
        ):
            file.write_bytes(damaged)
            try:
                load(file)
            except InputError as error:
                said.add(str(error))
    assert f"{file}: cannot be read as a numpy archive; write it with numpy.savez." in said


@pytest.mark.parametrize("crs", ["PROJCS[", "GEOGCS[]", "EPSG:999999", "", "+proj=utm +zone=99"])
def test_a_reference_system_that_is_none(tmp_path, capfd, crs):
    """GDAL prints nothing about it."""
    elevation = io.BytesIO()
    np.save(elevation, np.zeros((3, 3)))
    file = archive(tmp_path / "x.npz", elevation.getvalue(), crs=crs, origin=(1.0, 2.0))
    assert refusal(file) == (
        f"{file}: {crs!r} is no coordinate reference system; give EPSG:CODE or WKT."
    )
    assert capfd.readouterr() == ("", "")
