"""Files of a folder, replaced together or not at all, on a disk that fails at each call."""

import errno
import fcntl
import itertools
import os
import random
import signal
import threading

import pytest

from pathgene.host.files import replacement
from pathgene.host.files.disk import Disk, current, using
from pathgene.host.files.replacement import replace_files
from tools.faults.disk import FaultyDisk, Killed
from tools.faults.platter import Platter


OLD = {"a": b"old a", "c": b"old c", "gone": b"old gone", "last": b"old last"}
NEW = {"a": b"new a", "b": b"new b", "c": b"new c", "last": b"new last"}


@pytest.fixture
def folder(tmp_path):
    for name, content in OLD.items():
        (tmp_path / name).write_bytes(content)
    return tmp_path


def contents(directory):
    return {entry.name: entry.read_bytes() for entry in directory.iterdir()}


def replace(folder):
    replace_files(folder, NEW, gone=["gone", "missing"])


def calls_of(folder):
    with using(disk := FaultyDisk()):
        replace(folder)
    return disk.calls


def failure_of(folder):
    try:
        replace(folder)
    except OSError as error:
        return error
    return None


def test_replaces_and_removes(folder):
    replace(folder)
    assert contents(folder) == NEW


def test_the_last_file_comes_after_all_else(folder):
    names = [call for call in calls_of(folder) if call.startswith("rename")]
    assert names[0] == "rename a"
    assert names[-1] == "rename last"
    assert len(names) == 5  # Four files, and one that is removed.


@pytest.mark.parametrize("error", [errno.ENOSPC, errno.EIO, errno.EROFS])
@pytest.mark.parametrize("lasting", [False, True])
def test_every_failure_leaves_the_old_files_or_the_new_ones(folder, error, lasting):
    """A read-only disk that refuses to put files back is named in the error."""
    seen = set()
    for at in range(1, len(calls_of(folder)) + 1):
        for entry in folder.iterdir():
            entry.unlink()
        for name, content in OLD.items():
            (folder / name).write_bytes(content)
        with using(disk := FaultyDisk(at, error=error, lasting=lasting, seed=at)):
            failure = failure_of(folder)
        assert disk.failed or error == errno.ENOSPC  # Only unlinking is left.
        assert failure is None or failure.errno == error
        said = failure.strerror if failure else ""
        left = contents(folder)
        visible = {name: content for name, content in left.items() if name[0] != "."}
        if "put back" in said:
            assert lasting
            assert error != errno.ENOSPC
            assert visible["last"] == OLD["last"]
            assert set(OLD.values()) <= set(left.values())  # Hidden, but present.
        else:
            assert visible == (OLD if said else NEW)
            # Hidden files stay only if the disk refuses to remove them.
            refused = [call for call in disk.calls[at - 1 :] if call.startswith("unlink")]
            assert left == visible or (refused and error != errno.ENOSPC)
        seen.add(bool(said))
        replace(folder)
        assert contents(folder) == NEW
    assert seen == {False, True}


def test_the_only_copy_of_a_file_stays_until_a_replacement_succeeds(folder):
    """The disk refuses to rename an older file back, and then refuses the next replacement."""
    (folder / "gone").rename(folder / ".gone.0123abcd")
    (folder / ".a.0123abcd").write_bytes(b"left")
    with using(FaultyDisk(3, error=errno.ENOSPC, lasting=True)):
        assert failure_of(folder) is not None
    left = contents(folder)
    assert left.pop(".gone.0123abcd") == OLD["gone"]
    assert left == {name: content for name, content in OLD.items() if name != "gone"}
    replace(folder)
    assert contents(folder) == NEW


def test_a_killed_process_leaves_whole_files_and_the_next_one_clears_up(folder):
    mixed = 0
    for at in range(1, len(calls_of(folder)) + 1):
        for entry in folder.iterdir():
            entry.unlink()
        for name, content in OLD.items():
            (folder / name).write_bytes(content)
        with using(FaultyDisk(at, kill=True, seed=at)), pytest.raises(Killed):
            replace(folder)
        visible = {name: text for name, text in contents(folder).items() if name[0] != "."}
        for name, content in visible.items():
            assert content in (OLD.get(name), NEW.get(name))
        assert {"a", "c", "last"} <= visible.keys()  # No file is ever missing.
        if visible["last"] == NEW["last"]:
            assert visible == NEW
        mixed += visible not in (OLD, NEW)
        replace(folder)
        assert contents(folder) == NEW
    assert mixed


def test_a_loss_of_power_never_leaves_the_old_files_without_one_of_them(folder):
    """A missing file would not be noticed, a file of another run would be."""
    lost = 0
    for at in range(1, len(calls_of(folder)) + 1):
        # Seed 15 loses the new names alone if they are not synced before an older file goes.
        for seed in range(10, 20):
            for entry in folder.iterdir():
                entry.unlink()
            for name, content in OLD.items():
                (folder / name).write_bytes(content)
            platter = Platter(folder)
            with using(FaultyDisk(at, kill=True, platter=platter)), pytest.raises(Killed):
                replace(folder)
            platter.lose(random.Random(seed))
            visible = {name: text for name, text in contents(folder).items() if name[0] != "."}
            for name, content in visible.items():
                assert content in (OLD.get(name), NEW.get(name))
            assert visible == OLD or not visible.items() <= OLD.items()
            lost += visible not in (OLD, NEW)
            replace(folder)
            assert contents(folder) == NEW
    assert lost


def test_a_file_system_without_links(folder):
    class Plain(Disk):
        def link(self, source, target):
            raise OSError(errno.EPERM, os.strerror(errno.EPERM))

        def rename(self, source, target):
            if target.name == "last":
                raise OSError(errno.EIO, os.strerror(errno.EIO))
            super().rename(source, target)

    with using(Plain()), pytest.raises(OSError, match=os.strerror(errno.EIO)):
        replace(folder)
    assert contents(folder) == OLD


def test_a_folder_in_a_place_stays(folder):
    (folder / "b").mkdir()
    with pytest.raises(IsADirectoryError) as caught:
        replace(folder)
    assert caught.value.strerror == "b is a directory"
    (folder / "b").rmdir()
    (folder / "missing").mkdir()  # This one should be removed.
    replace(folder)
    (folder / "missing").rmdir()
    assert contents(folder) == NEW


def test_a_special_file_is_written_before_the_rest_and_stays(folder):
    os.mkfifo(folder / "b")
    os.mkfifo(folder / "missing")
    end = os.open(folder / "b", os.O_RDONLY | os.O_NONBLOCK)
    try:
        replace(folder)
        assert os.read(end, 100) == NEW["b"]
    finally:
        os.close(end)
    for name in ("b", "missing"):
        assert (folder / name).is_fifo()
        (folder / name).unlink()
    assert contents(folder) == {name: NEW[name] for name in ("a", "c", "last")}


def test_a_fifo_that_nobody_reads_changes_nothing(folder):
    before = contents(folder)
    os.mkfifo(folder / "b.fifo")
    with pytest.raises(OSError, match=r"b\.fifo is a pipe that nobody reads"):
        replace_files(folder, {"a": b"other", "b.fifo": b"other"})
    (folder / "b.fifo").unlink()
    assert contents(folder) == before


def test_signals_wait_for_the_end(folder):
    class Signalling(Disk):
        def rename(self, source, target):
            os.kill(os.getpid(), signal.SIGINT)
            super().rename(source, target)

    with pytest.raises(KeyboardInterrupt), using(Signalling()):
        replace(folder)
    assert contents(folder) == NEW


def test_two_writers_do_not_mix(folder):
    """While one writer is between two renames, the second writer waits."""
    inside, others = threading.Event(), []

    class Slow(Disk):
        def rename(self, source, target):
            if threading.current_thread() is threading.main_thread() and not inside.is_set():
                inside.set()
                others[0].join(0.3)
            super().rename(source, target)

    def other():
        inside.wait(10)
        replace_files(folder, dict.fromkeys(NEW, b"other"))

    others.append(threading.Thread(target=other))
    with using(Slow()):
        others[0].start()
        try:
            replace(folder)
        except OSError as error:
            pytest.fail(f"the second writer has not waited: {error}")
        others[0].join(10)
    assert contents(folder) == dict.fromkeys(NEW, b"other")


def test_a_lock_that_is_never_released_holds_nothing_up_for_ever(folder, monkeypatch):
    monkeypatch.setattr(replacement, "_PATIENCE_S", 0.1)
    hidden = folder / ".a.01234567"
    hidden.write_bytes(b"perhaps of the other")
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        replace(folder)
    finally:
        os.close(descriptor)
    assert contents(folder) == {**NEW, hidden.name: b"perhaps of the other"}
    replace(folder)
    assert contents(folder) == NEW


def test_hidden_files_of_others_stay(folder):
    for name in (".d.01234567", ".a.backup", "..a.01234567"):
        (folder / name).write_bytes(b"")
    replace(folder)
    assert len(list(itertools.filterfalse(lambda name: name in NEW, contents(folder)))) == 3


def test_another_disk_is_used_in_a_block_alone():
    usual, other = current(), Disk()

    def break_off():
        with using(other):
            assert current() is other
            raise RuntimeError("broken")

    with pytest.raises(RuntimeError, match=r"^broken$"):
        break_off()
    assert current() is usual


def test_a_new_file_never_replaces_one(tmp_path):
    disk = Disk()
    with disk.create(tmp_path / "a") as file:
        file.write(b"old")
        disk.sync(file)
        assert (tmp_path / "a").read_bytes() == b"old"
    with pytest.raises(FileExistsError):
        disk.create(tmp_path / "a")
    with disk.append(tmp_path / "a") as file:
        file.write(b" and new")
    assert (tmp_path / "a").read_bytes() == b"old and new"


def test_a_link_is_a_second_name_of_a_link(tmp_path):
    (tmp_path / "file").write_bytes(b"content")
    (tmp_path / "link").symlink_to("file")
    Disk().link(tmp_path / "link", tmp_path / "second")
    assert (tmp_path / "second").is_symlink()
