"""What all tests share: hypothesis' profile, Ctrl-C, and simulators that may be missing."""

import shutil
import signal

import pytest
from hypothesis import settings

from host.device.boards import open_board
from tests.chips import Pair, board_url
from tools.runner import SIMULATORS


# The same examples in every run: a failure can be repeated, and no test fails by a slow machine.
settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.load_profile("repeatable")

# A shell's background jobs ignore Ctrl-C and SIGQUIT, under nohup SIGHUP too, and so would every
# program that the tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)
for _number in (signal.SIGQUIT, signal.SIGHUP):
    signal.signal(_number, signal.SIG_DFL)


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


@pytest.fixture
def pair():
    """Opens a simulated board and the model of the same chip; closes both."""
    opened = []

    def open_pair(config, seed=1, **options):
        for url in (board_url("sim", config, **options), board_url("model", config)):
            opened.append(open_board(url))
        return Pair(*opened, seed)

    yield open_pair
    for chip in opened:
        chip.close()
