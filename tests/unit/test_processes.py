"""The processes that tests start."""

import ast
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.support.host import processes
from tests.support.host.processes import Started, slowdown


TESTS = Path(__file__).resolve().parents[1]
FOREVER = [sys.executable, "-c", "import time; print('begun', flush=True); time.sleep(600)"]
# Its child holds the pipe, and the session.
WITH_CHILD = ["sh", "-c", "sleep 600 & echo $!; wait"]


def failed(command, **options):
    """Start a command, read a line of it and fail; return its process and the line."""
    seen = []

    def fail():
        with Started(command, stdout=subprocess.PIPE, **options) as process:
            seen.extend((process, process.stdout.readline()))
            raise AssertionError

    with pytest.raises(AssertionError):
        fail()
    return seen


def test_a_failure_ends_the_process():
    process, line = failed(FOREVER)
    assert (line, process.returncode) == (b"begun\n", -signal.SIGKILL)


def test_a_failure_ends_the_children_of_a_session():
    _, child = failed(WITH_CHILD, start_new_session=True)
    file = Path(f"/proc/{int(child)}/stat")
    for _ in range(100):
        if not file.exists() or file.read_text().rpartition(")")[2].split()[0] == "Z":
            return
        time.sleep(0.05)
    pytest.fail("The child still runs.")


def test_a_process_that_runs_on_is_killed(monkeypatch):
    monkeypatch.setattr(processes, "_LIMIT_S", 0.2)
    with Started(["sleep", "600"]) as process:
        pass
    assert process.returncode == -signal.SIGKILL


def test_a_process_that_ends_is_waited_for():
    with Started(["sh", "-c", "sleep 0.2; exit 3"]) as process:
        pass
    assert process.returncode == 3


def test_a_machine_is_not_faster_than_its_processor():
    assert slowdown() >= 1


def popen_lines(text):
    """Return the lines with calls of ``Popen``, which waits for ever after a failure."""
    return [
        node.lineno
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Call)
        and getattr(node.func, "attr", getattr(node.func, "id", "")) == "Popen"
    ]


def test_tests_start_all_processes_that_way():
    texts = {path: path.read_text() for path in TESTS.rglob("*.py")}
    assert [path for path, text in texts.items() if "Popen(" in text and popen_lines(text)] == []


def test_other_processes_are_found():
    code = "with subprocess.Popen(command) as process:\n    Popen(command)\nStarted(command)\n"
    assert popen_lines(code) == [1, 2]
