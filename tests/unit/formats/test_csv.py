"""Paths as CSV."""

import re

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats.csv import read_csv


def written(tmp_path, text, encoding="utf-8"):
    file = tmp_path / "path.csv"
    file.write_bytes(text.encode(encoding))
    return file


def test_reads_rows_blank_lines_and_spaces(tmp_path):
    file = written(tmp_path, "\ufeffx, y ,z\r\n1,2,3\r\n\r\n-4.5, 5e2 ,6\r\n")
    assert np.array_equal(read_csv(file), [[1, 2, 3], [-4.5, 500, 6]])


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "{}: the first line must be the header x,y,z."),
        ("1,2,3\n4,5,6\n", "{}: the first line must be the header x,y,z."),
        ("x,y\n1,2\n", "{}: the first line must be the header x,y,z."),
        ("x,y,z\n1,2,3\n", "{}: a path needs two rows or more, the start first and the goal last."),
        ("x,y,z\n1,2,3\n4,5\n", "{}, line 3: must be three finite numbers x,y,z, not '4,5'."),
        (
            "x,y,z\n1,2,nan\n4,5,6\n",
            "{}, line 2: must be three finite numbers x,y,z, not '1,2,nan'.",
        ),
        ("x,y,z\n1,2,up\n4,5,6\n", "{}, line 2: must be three finite numbers x,y,z, not '1,2,up'."),
    ],
)
def test_refuses_bad_rows(tmp_path, text, sentence):
    file = written(tmp_path, text)
    with pytest.raises(InputError, match=f"^{re.escape(sentence.format(file))}$"):
        read_csv(file)


def test_refuses_other_files(tmp_path):
    with pytest.raises(InputError, match=r"not a CSV file; give one with the header x,y,z\.$"):
        read_csv(written(tmp_path, "x,y,\xff", "latin-1"))
    with pytest.raises(InputError, match=r"^Cannot read the path '.*' \(No such file or dir"):
        read_csv(tmp_path / "missing.csv")
