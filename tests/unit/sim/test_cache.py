import subprocess
import sys
from pathlib import Path

import pytest

from sim.cache import BuildCache, build_root, digest
from sim.exported import cached_verilog


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
from sim.cache import BuildCache
def build(directory):
    with open(sys.argv[2], "a") as file:
        file.write("built\\n")
    time.sleep(0.2)
    (directory / "whole").write_text("yes")
print((BuildCache(Path(sys.argv[1])).get("key", build) / "whole").read_text())
"""


def test_processes_share_one_build(tmp_path):
    command = [sys.executable, "-c", BUILDER, str(tmp_path / "builds"), str(tmp_path / "count")]
    root = Path(__file__).resolve().parents[3]
    running = [subprocess.Popen(command, stdout=subprocess.PIPE, cwd=root) for _ in range(3)]
    assert [process.communicate()[0] for process in running] == [b"yes\n"] * 3
    assert (tmp_path / "count").read_text() == "built\n"


def test_export_is_made_once_per_key(tmp_path):
    texts = iter(["first", "second"])

    def text(*key):
        return cached_verilog(lambda: next(texts), *key, build_dir=tmp_path)

    assert [text("a"), text("a"), text("b"), text("a")] == ["first", "first", "second", "first"]
