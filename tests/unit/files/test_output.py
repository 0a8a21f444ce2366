"""Files that are written completely or not at all."""

import contextlib
import json
import os
import pty
import select
import stat
import threading
from pathlib import Path

import pytest

from pathgene.host.errors import InputError
from pathgene.host.files.output import (
    output_file,
    prepare_directory,
    prepare_file,
    replacing,
    write_json,
)
from pathgene.host.files.special import is_special


def names(directory):
    return [entry.name for entry in directory.iterdir()]


def test_replaces_a_file_only_when_complete(tmp_path):
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


def test_json_refuses_unknown_types(tmp_path):
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
            f"Cannot write to the directory {str(place)!r} ({reason}); give another (--out)."
        )


@pytest.fixture
def full(tmp_path):
    """A device like /dev/full that a test may overwrite."""
    device = tmp_path / "full"
    try:
        os.mknod(device, stat.S_IFCHR | 0o666, os.makedev(1, 7))
        device.open("wb").close()
    except OSError as error:
        pytest.skip(f"Devices cannot be made here ({error.strerror})")
    return device


@pytest.mark.parametrize("linked", [False, True])
def test_a_device_stays_and_its_error_is_a_sentence(full, tmp_path, linked):
    file = full
    if linked:
        file = tmp_path / "link"
        file.symlink_to(full)
    prepare_file(file)
    with pytest.raises(InputError) as caught, output_file(file) as binary:
        binary.write(b"new")
    assert str(caught.value) == (
        f"Cannot write to {str(file)!r} (No space left on device); give another file (--out)."
    )
    assert full.is_char_device()
    assert file.is_symlink() == linked
    assert sorted(names(tmp_path)) == sorted({"full", file.name})


@contextlib.contextmanager
def reading(fifo):
    """Read a FIFO in the block, in a thread, until its writer closes it; yield its contents."""
    end = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    os.set_blocking(end, True)
    read = []

    def take():
        while select.select([end], [], [], 10)[0] and (some := os.read(end, 1 << 16)):
            read.append(some)

    reader = threading.Thread(target=take, daemon=True)
    reader.start()
    yield read
    reader.join(10)
    os.close(end)


@pytest.mark.parametrize("linked", [False, True])
def test_a_fifo_gets_the_text_and_stays(tmp_path, linked):
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    file = fifo
    if linked:
        file = tmp_path / "link"
        file.symlink_to("fifo")
    with reading(fifo) as read:
        write_json(file, {"x": 1})
    assert b"".join(read) == b'{\n "x": 1\n}\n'
    assert fifo.is_fifo()
    assert file.is_symlink() == linked


def test_a_fifo_gets_nothing_of_an_incomplete_file(tmp_path):
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    end = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)

    def break_off():
        with replacing(fifo) as binary:
            binary.write(b"half of the n")
            raise RuntimeError("broken")

    with pytest.raises(RuntimeError, match=r"^broken$"):
        break_off()
    assert os.read(end, 100) == b""
    os.close(end)


def test_a_fifo_gets_more_than_it_holds(tmp_path):
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    content = bytes(range(256)) * 4000
    with reading(fifo) as read, output_file(fifo) as binary:
        binary.write(content)
    assert b"".join(read) == content


def test_a_fifo_that_nobody_reads_is_refused_at_once(tmp_path):
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    with pytest.raises(InputError) as caught, output_file(fifo) as binary:
        binary.write(b"new")
    assert str(caught.value) == (
        f"Cannot write to {str(fifo)!r} (fifo is a pipe that nobody reads); give another file "
        "(--out)."
    )
    assert fifo.is_fifo()


@pytest.mark.parametrize("kind", ["pipe", "terminal"])
def test_a_reader_that_takes_nothing_more_is_given_up(tmp_path, monkeypatch, kind):
    monkeypatch.setattr("pathgene.host.files.special._PATIENCE_S", 0.2)
    file = tmp_path / "file"
    if kind == "pipe":
        os.mkfifo(file)
        ends = (os.open(file, os.O_RDONLY | os.O_NONBLOCK),)
    else:
        ends = pty.openpty()
        file.symlink_to(os.ttyname(ends[1]))
    caught = []

    def write():
        with pytest.raises(InputError) as error, output_file(file) as binary:
            binary.write(b"new\n" * 100_000)
        caught.append(str(error.value))

    writer = threading.Thread(target=write)
    writer.start()
    writer.join(10)
    goes_on = writer.is_alive()
    for end in ends:
        os.close(end)
    writer.join()
    assert not goes_on
    assert caught[0] == (
        f"Cannot write to {str(file)!r} (the reader of file has taken nothing for 0.2 s); give "
        "another file (--out)."
    )


def test_an_open_descriptor_is_written_at_its_position(tmp_path):
    log = tmp_path / "log"
    with log.open("wb", buffering=0) as opened:
        opened.write(b"before\n")
        link = tmp_path / "stdout"  # Like /dev/stdout.
        link.symlink_to(f"/proc/self/fd/{opened.fileno()}")
        with replacing(link) as binary:
            binary.write(b"content\n")
        opened.write(b"after\n")
    assert log.read_bytes() == b"before\ncontent\nafter\n"
    assert link.is_symlink()


def test_a_link_to_a_regular_file_is_replaced_and_its_target_stays(tmp_path):
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_bytes(b"old")
    link.symlink_to(target)
    assert not is_special(link)
    with replacing(link) as binary:
        binary.write(b"new")
    assert (link.read_bytes(), target.read_bytes()) == (b"new", b"old")
    assert sorted(names(tmp_path)) == ["link", "target"]


@pytest.mark.parametrize("digits", [5, 20, 5000])
def test_a_descriptor_that_no_process_has(digits):
    assert is_special(Path("/proc/self/fd", "9" * digits)) == (digits == 5)
    with pytest.raises(InputError, match=r"^Cannot write to "):
        with output_file(Path("/proc/self/fd", "9" * digits)) as binary:
            binary.write(b"new")
