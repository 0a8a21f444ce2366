"""The disk that fails at a chosen call."""

import errno

import pytest

from tools.faults.disk import FaultyDisk, Killed


def write(disk, folder):
    with disk.create(folder / "new") as file:
        file.write(b"content" * 1000)
        disk.sync(file)
    disk.rename(folder / "new", folder / "file")
    disk.unlink(folder / "file")


CALLS = ["create new", "write new", "sync new", "rename file", "unlink file"]


def test_counts_and_does_no_harm(tmp_path):
    disk = FaultyDisk()
    write(disk, tmp_path)
    assert disk.calls == CALLS
    assert not disk.failed
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("at", range(1, len(CALLS) + 1))
def test_one_call_fails(tmp_path, at):
    disk = FaultyDisk(at, error=errno.EIO)
    with pytest.raises(OSError, match="Input/output error") as caught:
        write(disk, tmp_path)
    assert caught.value.errno == errno.EIO
    assert disk.failed
    disk.make_directory(tmp_path / "later")


def test_a_write_is_torn_where_the_seed_says(tmp_path):
    sizes = []
    for seed in (1, 1, 2):
        disk = FaultyDisk(2, kill=True, seed=seed)
        with pytest.raises(Killed):
            write(disk, tmp_path)
        sizes.append((tmp_path / "new").stat().st_size)
        (tmp_path / "new").unlink()
    assert sizes[0] == sizes[1] != sizes[2]
    assert 0 < sizes[0] < 7000


def test_a_torn_write_may_lack_only_its_last_byte(tmp_path):
    sizes = []
    for seed in range(20):
        disk = FaultyDisk(2, kill=True, seed=seed)
        with pytest.raises(Killed):
            write(disk, tmp_path)
        sizes.append((tmp_path / "new").stat().st_size)
        (tmp_path / "new").unlink()
    assert 0 < sizes.count(7 * 1000 - 1) < 10


def test_a_full_disk_still_renames_and_removes(tmp_path):
    (tmp_path / "new").write_bytes(b"")
    disk = FaultyDisk(1, lasting=True)
    for _ in range(2):
        with pytest.raises(OSError, match="No space left on device"):
            disk.create(tmp_path / "other")
    disk.rename(tmp_path / "new", tmp_path / "file")
    disk.unlink(tmp_path / "file")


def test_a_lasting_fault_ends_after_some_calls(tmp_path):
    disk = FaultyDisk(1, error=errno.EIO, lasting=True, calls=2)
    for _ in range(2):
        with pytest.raises(OSError, match="Input/output error"):
            disk.create(tmp_path / "new")
    write(disk, tmp_path)
    assert disk.refused == ["create new"] * 2


@pytest.mark.parametrize("options", [{"kill": True}, {"lasting": True, "error": errno.EROFS}])
def test_other_disks_refuse_every_later_call(tmp_path, options):
    (tmp_path / "new").write_bytes(b"")
    disk = FaultyDisk(1, **options)
    for call in (
        lambda: disk.append(tmp_path / "new"),
        lambda: disk.rename(tmp_path / "new", tmp_path / "file"),
        lambda: disk.unlink(tmp_path / "new"),
        lambda: disk.link(tmp_path / "new", tmp_path / "file"),
        lambda: disk.make_directory(tmp_path / "folder"),
        lambda: disk.sync_directory(tmp_path),
    ):
        with pytest.raises((Killed, OSError)) as caught:
            call()
        assert isinstance(caught.value, Killed) == options.get("kill", False)
    assert [entry.name for entry in tmp_path.iterdir()] == ["new"]
