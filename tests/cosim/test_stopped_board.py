"""A stopped simulator: its host stops waiting in time."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pathgene.host.device.boards import open_board
from pathgene.host.device.link import LinkTimeoutError
from pathgene.host.errors import InputError
from pathgene.sim.board.scheme import start_simulated
from tests.support.gateware.chips import CHECKING
from tests.support.host.processes import Started
from tools.chips import board_url


pytestmark = pytest.mark.cosim

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.ci
@pytest.mark.parametrize("pty", [True, False])
def test_a_stopped_simulator_costs_the_patience(pty):
    """It stops in the middle of an upload, or before the first answer."""
    with start_simulated(board_url("sim", CHECKING), pty=pty, keep=True) as board:
        size = CHECKING.map_size
        with open_board(f"{board.url}?patience=1.5") as client:
            client.upload_map([[1] * size] * size)
            os.kill(board.pid, signal.SIGSTOP)
            begun = time.monotonic()
            with pytest.raises(LinkTimeoutError, match=r"^The board (did not answer MAP|took no)"):
                client.upload_map([[2] * size] * size)
            assert 1.5 <= time.monotonic() - begun < 6
            with pytest.raises(InputError, match=r"^Nothing answers at "):
                open_board(f"{board.url}?patience=0.5")
            os.kill(board.pid, signal.SIGCONT)
            client.update_map([[3] * size] * size)
            assert client.check_path([0, 1], counting=True)


@pytest.mark.ci
def test_a_simulator_that_stops_ends_a_plan_with_a_sentence_and_status_1(tmp_path):
    terrain = tmp_path / "plain.npz"
    np.savez(terrain, elevation=np.zeros((21, 21)), dx_m=100.0, dy_m=100.0)
    with start_simulated(board_url("sim", CHECKING), pty=True, keep=True) as board:
        command = [sys.executable, "-m", "pathgene", "plan", "--terrain", terrain, "--agl",
                   "--start",
                   "100,100,50", "--goal", "1900,1900,50", "--board", f"{board.url}?patience=1",
                   "--planner", "ga-fpga", "--generations", "1000000",
                   "--out", tmp_path / "out"]  # fmt: skip
        with Started(command, cwd=ROOT, stderr=subprocess.PIPE, text=True) as process:
            while not process.stderr.readline().startswith("generation 0/"):
                assert process.poll() is None
            os.kill(board.pid, signal.SIGSTOP)
            error = process.communicate(timeout=300)[1]
    assert process.returncode == 1
    assert error.splitlines()[-1].startswith("pathgene: The board did not answer GENERATE in 5 ")
