"""Files that are whole or not there."""

import json

import pytest

from host.errors import InputError
from host.report.files import prepare_directory, replacing, write_json


def names(directory):
    return [entry.name for entry in directory.iterdir()]


def test_replaces_only_when_whole(tmp_path):
    file = tmp_path / "a.bin"
    file.write_bytes(b"old")

    def break_off():
        with replacing(file) as binary:
            binary.write(b"half of the n")
            raise RuntimeError("broken")

    with pytest.raises(RuntimeError, match=r"^broken$"):
        break_off()
    assert file.read_bytes() == b"old"
    assert names(tmp_path) == ["a.bin"]

    with replacing(file) as binary:
        binary.write(b"new")
        assert file.read_bytes() == b"old"
    assert file.read_bytes() == b"new"
    assert names(tmp_path) == ["a.bin"]


def test_json_refuses_what_json_does_not_know(tmp_path):
    file = tmp_path / "a.json"
    with pytest.raises(ValueError, match="Out of range float values are not JSON compliant"):
        write_json(file, {"x": float("nan")})
    assert not names(tmp_path)
    write_json(file, {"x": [1, None]})
    assert json.loads(file.read_text()) == {"x": [1, None]}
    assert file.read_text().endswith("}\n")


def test_makes_directories_and_leaves_nothing(tmp_path):
    directory = tmp_path / "a" / "b"
    prepare_directory(directory)
    prepare_directory(directory)
    assert names(directory) == []


def test_refuses_a_file_in_the_way(tmp_path):
    (tmp_path / "a").write_text("a file")
    for place in (tmp_path / "a", tmp_path / "a" / "b"):
        with pytest.raises(InputError) as caught:
            prepare_directory(place)
        reason = "File exists" if place.name == "a" else "Not a directory"
        assert str(caught.value) == (
            f"Cannot write to the directory {str(place)!r} ({reason}); give another with --out.")
