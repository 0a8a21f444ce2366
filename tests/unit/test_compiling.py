"""Compilation in another process, and signals meanwhile."""

import importlib
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from numba import types

from pathgene.host import compiling
from pathgene.jit import compile_by, compiling_s
from tests.support.host.processes import Started, slowdown


ROOT = Path(__file__).resolve().parents[2]
KERNEL = """
from pathgene.host.evaluation.jit import compiled

@compiled
def kernel_apart(x):
    return 3 * x
"""
# Waits for the helper, which sleeps, in the main thread or in another.
WAITING = """
import sys
from concurrent.futures import ThreadPoolExecutor
from pathgene.host import compiling, interrupts

def wait():
    print("begun", flush=True)
    compiling._HELPER.call("time", "sleep", 600)

with interrupts.caught():
    try:
        if sys.argv[1] == "main":
            wait()
        else:
            with ThreadPoolExecutor(1) as pool:
                pool.submit(wait).result()
    except KeyboardInterrupt:
        compiling.end()
        sys.exit(interrupts.status())
"""


@pytest.fixture
def kernel(tmp_path, monkeypatch):
    """A kernel that is on no disk, in a module that other processes find."""
    (tmp_path / "kernel_apart.py").write_text(KERNEL)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    yield importlib.import_module("kernel_apart").kernel_apart
    compiling.end()
    del sys.modules["kernel_apart"]


def counts(kernel):
    return sum(kernel.stats.cache_hits.values()), sum(kernel.stats.cache_misses.values())


def test_a_kernel_is_compiled_apart(kernel):
    compiling.compile_apart()
    begun_s, compiled_s = time.perf_counter(), compiling_s()
    assert kernel(2) == 6
    assert counts(kernel) == (1, 0)
    # It starts Python and loads numba.
    assert 0.05 < compiling_s() - compiled_s < time.perf_counter() - begun_s
    # The same helper compiles for another type.
    helper = compiling._HELPER._process
    assert kernel(0.5) == 1.5
    assert counts(kernel) == (2, 0)
    assert compiling._HELPER._process is helper
    seen = []
    compiling._HELPER.call(
        "kernel_apart", "kernel_apart.compile", (types.int32,), progress=seen.append
    )
    assert seen == [1]
    compiling.end()
    assert helper.returncode is not None


def test_a_kernel_that_the_helper_does_not_find_is_compiled_here(kernel, monkeypatch):
    monkeypatch.delenv("PYTHONPATH")
    compiling.compile_apart()
    assert kernel(2) == 6
    assert counts(kernel) == (0, 1)


def test_an_interrupt_of_the_wait_leaves_the_compiler_free(kernel):
    def interrupted(*request):
        raise KeyboardInterrupt

    compile_by(interrupted)
    with pytest.raises(KeyboardInterrupt):
        kernel(2)
    compile_by(None)
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(kernel, 2).result(timeout=60) == 6


@pytest.mark.ci
def test_a_kernel_is_compiled_here_if_the_helper_dies(kernel):
    compiling.compile_apart()
    compiling._HELPER.call("os", "_exit", 1)
    compiling._HELPER.call("time", "sleep", 0)  # Starts it again.
    compiling._HELPER._process.kill()
    assert kernel(2) == 6
    assert counts(kernel) == (0, 1)


@pytest.mark.parametrize("thread", ["main", pytest.param("other", marks=pytest.mark.ci)])
def test_a_signal_ends_the_wait(thread):
    command = [sys.executable, "-c", WAITING, thread]
    with Started(command, cwd=ROOT, stdout=subprocess.PIPE, start_new_session=True) as process:
        assert process.stdout.readline() == b"begun\n"
        time.sleep(0.5)
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        begun_s = time.monotonic()
        process.send_signal(signal.SIGTERM)
        assert process.wait(60) == 128 + signal.SIGTERM
        assert time.monotonic() - begun_s < 2 * slowdown()
    assert all(not Path(f"/proc/{child}").exists() for child in children)
