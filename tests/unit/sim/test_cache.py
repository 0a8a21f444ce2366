import contextlib
import errno
import fcntl
import logging
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pathgene.host.errors import JobError
from pathgene.host.files.disk import using
from pathgene.sim.cache import BuildCache, build_root, digest
from pathgene.sim.exported import cached_verilog
from tests.support.host.processes import Started
from tools.faults.disk import FaultyDisk, Killed


ROOT = Path(__file__).resolve().parents[3]


def test_build_root_of_a_checkout():
    assert build_root() == Path(__file__).resolve().parents[3] / "build"


def test_digest_depends_on_parts_and_their_ends():
    keys = {digest(parts) for parts in (["ab"], ["a", "b"], ["b", "a"], ["ab", ""], [""], [])}
    assert len(keys) == 6
    assert digest(["a", b"b"]) == digest([b"a", "b"])


def test_builds_once(tmp_path):
    calls = []

    def build(directory):
        calls.append(directory)
        (directory / "file").write_text("text")

    builds = BuildCache(tmp_path / "new" / "root")
    first = builds.get("key", build)
    assert builds.get("key", build) == first == tmp_path / "new" / "root" / "key"
    assert (first / "file").read_text() == "text"
    assert len(calls) == 1


def test_failed_build_leaves_nothing(tmp_path):
    def fail(directory):
        (directory / "half").write_text("")
        raise RuntimeError("no")

    builds = BuildCache(tmp_path)
    with pytest.raises(RuntimeError, match=r"^no$"):
        builds.get("key", fail)
    assert [path.name for path in tmp_path.iterdir()] == ["key.lock"]
    assert builds.get("key", lambda directory: None).is_dir()


def test_key_is_a_plain_name(tmp_path):
    with pytest.raises(ValueError, match=r"^Key must be letters, digits, '-' and '_', not '\.\.'$"):
        BuildCache(tmp_path).get("..", lambda directory: None)


BUILDER = """
import sys, time
from pathlib import Path
from pathgene.sim.cache import BuildCache
def build(directory):
    with open(sys.argv[2], "a") as file:
        file.write("built\\n")
    time.sleep(0.2)
    (directory / "whole").write_text("yes")
print((BuildCache(Path(sys.argv[1])).get("key", build) / "whole").read_text())
"""


def test_processes_share_one_build(tmp_path):
    command = [sys.executable, "-c", BUILDER, str(tmp_path / "builds"), str(tmp_path / "count")]
    with contextlib.ExitStack() as blocks:
        running = [
            blocks.enter_context(Started(command, stdout=subprocess.PIPE, cwd=ROOT))
            for _ in range(3)
        ]
        assert [process.communicate()[0] for process in running] == [b"yes\n"] * 3
    assert (tmp_path / "count").read_text() == "built\n"


def test_export_is_made_once_per_key(tmp_path):
    texts = iter(["first", "second"])

    def text(*key):
        return cached_verilog(lambda: next(texts), *key, build_dir=tmp_path)

    assert [text("a"), text("a"), text("b"), text("a")] == ["first", "first", "second", "first"]


def build_program(directory):
    (directory / "program").write_bytes(bytes(range(256)) * 20)
    (directory / "part").mkdir()
    (directory / "part" / "design.v").write_text("module")


def cut(directory):
    program = directory / "program"
    program.write_bytes(program.read_bytes()[:-1000])


def flip(directory):
    design = directory / "part" / "design.v"
    design.write_text("nodule")


def remove_program(directory):
    (directory / "program").unlink()


def remove_sums(directory):
    (directory / "SHA256SUMS").unlink()


def empty_sums(directory):
    (directory / "SHA256SUMS").write_text("")


def add(directory):
    (directory / "other").write_text("")


@pytest.mark.parametrize("harm", [cut, flip, remove_program, remove_sums, empty_sums, add])
def test_a_damaged_directory_is_built_anew_with_a_note(tmp_path, caplog, harm):
    caplog.set_level(logging.INFO, "pathgene.build")
    builds = BuildCache(tmp_path)
    whole = builds.get("chip-1", build_program)
    content = {path: path.read_bytes() for path in whole.rglob("*") if path.is_file()}
    harm(whole)
    caplog.clear()
    assert builds.get("chip-1", build_program) == whole
    assert caplog.messages == [
        "the files of chip are damaged",
        "building chip; it is kept for the next time",
    ]
    assert {path: path.read_bytes() for path in whole.rglob("*") if path.is_file()} == content
    assert sorted(path.name for path in tmp_path.iterdir()) == ["chip-1", "chip-1.lock"]
    builds.get("chip-1", lambda directory: pytest.fail("built again"))


def test_the_checksums_are_those_of_sha256sum(tmp_path):
    directory = BuildCache(tmp_path).get("chip-1", build_program)
    command = ["sha256sum", "--check", "--strict", "SHA256SUMS"]
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True, check=True)
    assert done.stdout == "part/design.v: OK\nprogram: OK\n"


def test_a_program_is_checked_in_tens_of_milliseconds(tmp_path):
    """The program has 20 MB, four times the size of the default chip's."""
    builds = BuildCache(tmp_path)

    def build(directory):
        (directory / "program").write_bytes(bytes(20_000_000))

    builds.get("chip-1", build)
    times = []
    for _ in range(5):
        started = time.perf_counter()
        builds.get("chip-1", build)
        times.append(time.perf_counter() - started)
    assert min(times) < 0.2  # A processor without instructions for SHA takes 100 ms.


@pytest.mark.parametrize("error", [errno.EROFS, errno.ENOSPC])
def test_a_cache_that_takes_nothing_is_a_sentence(tmp_path, error):
    builds = BuildCache(tmp_path)
    kept = builds.get("kept-1", build_program)
    with using(disk := FaultyDisk()):
        builds.get("count-1", build_program)
    for at in range(1, len(disk.calls) + 1):
        with using(FaultyDisk(at, error=error, lasting=True, seed=at)):
            assert builds.get("kept-1", build_program) == kept
            if error == errno.ENOSPC and at == len(disk.calls):  # Renames.
                continue
            with pytest.raises(JobError) as caught:
                builds.get("chip-1", build_program)
        assert str(caught.value) == (
            f"Cannot build in {str(tmp_path)!r} ({os.strerror(error)}); free space or permit "
            "writing there, or move the checkout; an installed pathgene builds in the directory "
            "that XDG_CACHE_HOME names."
        )
        assert [path.name for path in tmp_path.glob("chip-1*")] in ([], ["chip-1.lock"])


def test_a_killed_build_leaves_no_program_and_the_next_one_clears_up(tmp_path):
    builds = BuildCache(tmp_path)
    with using(disk := FaultyDisk()):
        builds.get("count-1", build_program)
    for at in range(1, len(disk.calls) + 1):
        key = f"chip-{at}"
        with using(FaultyDisk(at, kill=True, seed=at)), pytest.raises(Killed):
            builds.get(key, build_program)
        assert not (tmp_path / key).exists()
        (tmp_path / f"{key}.01234567").mkdir()  # Left by a build that was killed outright.
        assert builds.get(key, build_program).is_dir()
        assert sorted(path.name for path in tmp_path.glob(f"{key}*")) == [key, f"{key}.lock"]


def test_a_build_removes_what_killed_builds_of_any_key_have_left(tmp_path):
    """Directories that a process is still building stay, and so do unrelated names."""
    left = [tmp_path / "chip-1.01234567", tmp_path / "old-2.89abcdef"]
    others = [tmp_path / "notes.thisyear", tmp_path / "busy-3.01234567"]
    for directory in (*left, *others):
        (directory / "part").mkdir(parents=True)
    builds = BuildCache(tmp_path)
    with (tmp_path / "busy-3.lock").open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        builds.get("chip-1", build_program)
        assert [directory.exists() for directory in (*left, *others)] == [False, False, True, True]
    builds.get("chip-4", build_program)
    assert [directory.exists() for directory in others] == [True, False]


def test_builds_side_by_side_leave_each_other_alone(tmp_path):
    def build(directory):
        build_program(directory)
        BuildCache(tmp_path).get("inner-1", build_program)

    assert (BuildCache(tmp_path).get("outer-1", build) / "program").exists()


def test_what_is_no_directory_stays(tmp_path):
    os.mkfifo(tmp_path / "chip-1")
    with pytest.raises(JobError, match="chip-1 is no directory"):
        BuildCache(tmp_path).get("chip-1", build_program)
    assert (tmp_path / "chip-1").is_fifo()


COMPILING = """
import sys
from pathlib import Path
from pathgene.sim.cache import BuildCache
from pathgene.sim.compiler import run_tool
def build(directory):
    script = "sleep 600 & echo $! > child; echo $$ >> child; mv child pids; wait"
    run_tool(["sh", "-c", script], cwd=directory, what="It")
BuildCache(Path(sys.argv[1])).get("key", build)
"""


def test_sigkill_of_a_builder_ends_its_tools_and_the_next_build_removes_its_folder(tmp_path):
    with Started([sys.executable, "-c", COMPILING, str(tmp_path)], cwd=ROOT) as process:
        deadline = time.monotonic() + 60
        while not (found := list(tmp_path.glob("key.*/pids"))):
            assert time.monotonic() < deadline
            time.sleep(0.01)
        pids = list(map(int, found[0].read_text().split()))
        process.send_signal(signal.SIGKILL)
    assert len(pids) == 2
    while any(map(is_running, pids)):
        assert time.monotonic() < deadline
        time.sleep(0.01)
    assert len(list(tmp_path.glob("key.????????"))) == 1
    BuildCache(tmp_path).get("other", build_program)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["key.lock", "other", "other.lock"]


def is_running(pid):
    """Return whether a process exists and is not a zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False
