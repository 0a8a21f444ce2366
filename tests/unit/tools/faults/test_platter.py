"""The part of a folder that survives a loss of power."""

import random

import pytest

from tools.faults.disk import FaultyDisk
from tools.faults.platter import Platter


OLD, NEW = b"old" * 500, b"new" * 1500


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "file").write_bytes(OLD)
    return tmp_path


def states(folder, work):
    """Return the contents of ``file`` and the names in the folder after losses at the end."""
    found = set()
    for seed in range(60):
        for file in folder.iterdir():
            file.unlink()
        (folder / "file").write_bytes(OLD)
        platter = Platter(folder)
        work(FaultyDisk(platter=platter))
        platter.lose(random.Random(seed))
        names = frozenset(file.name for file in folder.iterdir())
        found.add(((folder / "file").read_bytes() if "file" in names else None, names))
    return found


def create(disk, folder, *, synced):
    with disk.create(folder / "new") as file:
        file.write(NEW)
        if synced:
            disk.sync(file)


def test_synced_files_and_names_survive(folder):
    def work(disk):
        create(disk, folder, synced=True)
        disk.rename(folder / "new", folder / "file")
        disk.sync_directory(folder)

    assert states(folder, work) == {(NEW, frozenset({"file"}))}


def test_each_change_of_a_name_may_be_lost(folder):
    def work(disk):
        create(disk, folder, synced=True)
        disk.link(folder / "file", folder / "older")
        disk.rename(folder / "new", folder / "file")

    found = states(folder, work)
    assert {content for content, _ in found} == {OLD, NEW}
    assert {frozenset({"file"}), frozenset({"file", "older"})} < {names for _, names in found}
    # Also out of order: renamed, but the earlier link is lost.
    assert (NEW, frozenset({"file"})) in found


def test_a_removed_file_may_return(folder):
    found = states(folder, lambda disk: disk.unlink(folder / "file"))
    assert found == {(OLD, frozenset({"file"})), (None, frozenset())}


def test_bytes_that_are_not_synced_may_be_lost(folder):
    def work(disk):
        create(disk, folder, synced=False)
        disk.rename(folder / "new", folder / "file")
        disk.sync_directory(folder)

    contents = [content for content, _ in states(folder, work)]
    assert any(len(content) < len(NEW) for content in contents)
    assert any(b"\0" in content and b"n" in content for content in contents)


def test_an_append_keeps_the_synced_bytes(folder):
    def work(disk):
        with disk.append(folder / "file") as file:
            file.write(NEW)

    found = [content for content, _ in states(folder, work)]
    assert all(content.startswith(OLD) for content in found)
    assert min(map(len, found)) < len(OLD + NEW)


def test_a_file_may_lack_only_its_last_byte(folder):
    def work(disk):
        create(disk, folder, synced=False)
        disk.rename(folder / "new", folder / "file")
        disk.sync_directory(folder)

    assert (NEW[:-1], frozenset({"file"})) in states(folder, work)
