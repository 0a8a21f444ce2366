"""What all tests share: hypothesis' profile, Ctrl-C, and simulators that may be missing."""

import shutil
import signal

import pytest
from hypothesis import settings

from sim.runner import SIMULATORS


# The same examples in every run: a failure can be repeated, and no test fails by a slow machine.
settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.load_profile("repeatable")

# A shell's background jobs ignore Ctrl-C, and so would every program that the tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def icarus():
    """Skips where Icarus Verilog is not installed: the one simulator that is no Python package."""
    if shutil.which("iverilog") is None:
        pytest.skip("Icarus Verilog is not installed (Debian package iverilog)")


@pytest.fixture(params=SIMULATORS)
def simulator(request):
    """Each Verilog simulator in turn."""
    if request.param == "icarus":
        request.getfixturevalue("icarus")
    return request.param
