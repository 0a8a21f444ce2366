"""Data files of a run, which its summary knows by their digests."""

import hashlib
import os

import pytest

from pathgene.host.errors import InputError
from pathgene.host.report.run_files import digests, verify


@pytest.fixture
def run(tmp_path):
    """Summary of a run with a grid and a path, and the function that writes a file next to it."""

    def write(name, content):
        (tmp_path / name).write_bytes(content)

    contents = {"terrain.npz": b"grid", "path.geojson": b"path"}
    for name, content in contents.items():
        write(name, content)
    return tmp_path / "summary.json", {"files": digests(contents)}, write


def test_digests_are_those_of_sha256():
    assert digests({"a": b"content"}) == {"a": hashlib.sha256(b"content").hexdigest()}


def test_accepts_what_belongs_to_the_run(run):
    file, summary, write = run
    verify(file, summary)
    write("path.png", b"pictures are drawn later")
    write("flight.json", b"of another command")
    file.with_name("path.geojson").unlink()  # Deleted on purpose.
    verify(file, summary)


@pytest.mark.parametrize("name", ["path.geojson", "terrain.npz", "path.plan", "path.kml"])
def test_names_a_file_that_is_altered_or_of_another_run(run, name):
    file, summary, write = run
    write(name, b"other")
    with pytest.raises(InputError) as caught:
        verify(file, summary)
    assert str(caught.value) == (
        f"{file.with_name(name)} is not the file that the run of {file} wrote, but altered or of "
        "another run; remove it, or plan again."
    )
    file.with_name(name).unlink()
    verify(file, summary)


def test_a_summary_of_an_earlier_version_says_nothing(run):
    file, _, write = run
    write("path.kml", b"of another run")
    verify(file, {})


def test_what_is_no_regular_file_is_not_read(run):
    file, summary, _ = run
    os.mkfifo(file.with_name("path.kml"))
    file.with_name("path.plan").mkdir()
    verify(file, summary)


@pytest.mark.parametrize("files", [[], "a", {"a": 1}, {"../a": "0"}, {"/etc/passwd": "0"}])
def test_refuses_bad_tables(run, files):
    file, _, _ = run
    with pytest.raises(InputError) as caught:
        verify(file, {"files": files})
    assert str(caught.value) == (
        f"{file}: files must be a table of the SHA-256 of each file by its name."
    )
