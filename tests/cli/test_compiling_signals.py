"""Signals during the first compilation, which takes up to a minute."""

import os
import signal
import subprocess
import time

import pytest

from tests.support.host.processes import slowdown

from .conftest import ENDS, is_gone, started, wait_for


@pytest.mark.parametrize("wait_s", [0.0, 1.5, pytest.param(6.0, marks=pytest.mark.ci)])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it(hills, tmp_path, number, wait_s):
    """No process is left, and the command ends with the status of the signal."""
    out = tmp_path / "out"
    arguments = ["plan", "--terrain", hills, *ENDS, "--planner", "ga-pc", "--out", out]
    cache = {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    with started(*arguments, env={**os.environ, **cache}, start_new_session=True) as process:
        wait_for(process, "pathgene: Compiling for this machine, once")
        time.sleep(wait_s)
        begun_s = time.monotonic()
        process.send_signal(number)
        try:
            error = process.communicate(timeout=60)[1]
        except subprocess.TimeoutExpired:
            pytest.fail("the command continues")
        took_s = time.monotonic() - begun_s
    assert process.returncode == 128 + number
    assert error == "pathgene: Interrupted before the end.\n"
    assert took_s < 2 * slowdown()
    assert list(out.iterdir()) == []
    assert is_gone(process.pid)
