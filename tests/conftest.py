"""Settings and fixtures of all tests: hypothesis profile, signals, simulators, boards."""

import gc
import shutil
import signal

import pytest
from hypothesis import settings

from pathgene.host.device.boards import open_board
from tests.support.gateware.chips import Pair
from tools.chips import board_url
from tools.runner import SIMULATORS


# The same examples in every run, without deadlines, so that failures are reproducible and slow
# machines do not fail.
settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.load_profile("repeatable")

# A shell's background jobs ignore Ctrl-C and SIGQUIT, and SIGHUP under nohup. Programs that the
# tests start must not inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
for _number in (signal.SIGQUIT, signal.SIGHUP):
    signal.signal(_number, signal.SIG_DFL)


# Elaboration makes millions of objects, and nearly all die without the collector.
gc.set_threshold(20_000, 20, 20)


def pytest_sessionstart(session):
    """Let workers begin with different kernels, so that few are compiled twice."""
    worker = getattr(session.config, "workerinput", None)
    if worker is not None:
        # It loads numba, which a single test may do without.
        from tests.support.host.kernels import compile_evaluation, written_page

        is_even = int(worker["workerid"].removeprefix("gw")) % 2 == 0
        (compile_evaluation if is_even else written_page)()


@pytest.hookimpl(wrapper=True)
def pytest_collection(session):
    """Collect no garbage while the tests are collected, and exempt them from it afterwards.

    The tests stay alive, so nothing is found. It takes a sixth of the time, in each worker.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_runtest_teardown(item, nextitem):
    """Exempt the live objects from garbage collection after each module of tests.

    Caches of syntax trees and of gateware have millions of objects, which each collection would
    visit, two seconds of the processor. NiceGUI's simulation of a user collects twice.
    """
    yield
    if nextitem is None or nextitem.path != item.path:
        gc.collect()
        gc.freeze()


@pytest.fixture
def icarus():
    """Skip the test if Icarus Verilog, which is not a Python package, is not installed."""
    if shutil.which("iverilog") is None:
        pytest.skip("Icarus Verilog is not installed (Debian package iverilog)")


@pytest.fixture(params=SIMULATORS)
def simulator(request):
    """Name of each Verilog simulator in turn."""
    if request.param == "icarus":
        request.getfixturevalue("icarus")
    return request.param


@pytest.fixture
def pair():
    """Function that opens a simulated board and its model, closed after the test."""
    opened = []

    def open_pair(config, seed=1, **options):
        for url in (board_url("sim", config, **options), board_url("model", config)):
            opened.append(open_board(url))
        return Pair(*opened, seed)

    yield open_pair
    for chip in opened:
        chip.close()
