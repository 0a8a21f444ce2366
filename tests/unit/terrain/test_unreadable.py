"""Files that are no rasters of heights, each with its reason."""

import gzip

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.terrain import load


PACKED = "is packed; unpack it, and give the raster in it."


def refusal(source, **options):
    with pytest.raises(InputError) as error:
        load(source, **options)
    return str(error.value)


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("a.tif", b"", "is empty; get it again."),
        ("N46E008.hgt.gz", gzip.compress(bytes(50), mtime=0), PACKED),
        ("a.zip", b"PK\x03\x04" + bytes(50), PACKED),
        ("a.tif", b"\n<!DOCTYPE html><html>", "is a web page: the download failed; get the "),
        ("N46E008.hgt", b"<html><body>404", "is a web page: the download failed; get the file"),
        (
            "a.tif",
            b"version https://git-lfs.github.com/spec/v1\noid",
            "is a pointer of git-lfs,",
        ),
        ("a.tif", b"II*\x00\x08\x00\x00\x00", "is a TIFF that is cut short or damaged; get it"),
        (
            "a.json",
            b'{"type": "FeatureCollection", "features": []}',
            "holds zones, not heights;",
        ),
        (
            "a.kml",
            b'<?xml version="1.0"?><kml><Document/></kml>',
            "holds zones, not heights; gi",
        ),
    ],
)
@pytest.mark.parametrize("self_contained", [False, True])
def test_another_kind_of_file(tmp_path, name, content, reason, self_contained):
    file = tmp_path / name
    file.write_bytes(content)
    assert refusal(file, self_contained=self_contained).startswith(f"{file}: {reason}")


@pytest.mark.parametrize("self_contained", [False, True])
def test_cut_short(write_tif, self_contained):
    tif = write_tif(np.random.default_rng(1).normal(size=(300, 300)))
    tif.write_bytes(tif.read_bytes()[:100_000])
    assert refusal(tif, self_contained=self_contained) == (
        f"{tif}: is a TIFF that is cut short or damaged; get it again."
    )
