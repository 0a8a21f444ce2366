"""Uploads of a full-size map over the line of a simulated board."""

import os
import signal

import numpy as np
import pytest

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.host.device.boards import open_board
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link, LinkTimeoutError
from pathgene.sim.board.scheme import start_simulated
from tools.chips import board_url


pytestmark = [pytest.mark.cosim, pytest.mark.long]

BITS_PER_BYTE = 10


BUILDS = [
    Config(checker=checker, lanes=lanes, clocks_per_bit=4)
    for checker, lanes in ((CheckerBuild.PARALLEL, 8), (CheckerBuild.TWO_TIER, 1))
]


@pytest.mark.parametrize("config", BUILDS, ids=lambda config: config.checker.value)
def test_the_line_is_never_idle(config):
    """The upload takes at most 1.11 times the cycles of the cells' bytes; the map is correct."""
    edge = config.map_size
    heights = np.random.default_rng(1).integers(0, 1 << config.altitude_bits, (edge, edge))
    with (
        open_board(board_url("sim", config)) as board,
        open_board(board_url("model", config)) as model,
    ):
        before = board.counters()
        board.upload_map(heights)
        after = board.counters()
        cycles = after["clocks"] - before["clocks"]
        line = heights.size * config.altitude_bits // 8 * BITS_PER_BYTE * config.clocks_per_bit
        assert line < cycles <= 1.11 * line
        assert board.link.traffic.frames_repeated == 0

        model.upload_map(heights)
        check_the_same(board, model)


def check_the_same(board, model):
    """Compare the counted collisions of random paths on both."""
    config = board.config
    edge = config.map_size
    # High altitudes, so that few cells collide.
    rng = np.random.default_rng(2)
    top = config.blocked_altitude
    for _ in range(20):
        x, y, z = rng.integers(0, (edge, edge, 4), (10, 3)).T
        points = (x | y << config.coordinate_bits) | (top - z) << 2 * config.coordinate_bits
        path = points.tolist()
        assert board.check_path(path, counting=True) == model.check_path(path, counting=True)


def test_an_interrupted_upload_is_resumed():
    """The board stops halfway, the host gives up, and later sends the missing cells."""
    config = BUILDS[0]
    edge = config.map_size
    heights = np.random.default_rng(1).integers(0, 1 << config.altitude_bits, (edge, edge))
    with (
        start_simulated(board_url("sim", config)) as simulated,
        open_board(board_url("model", config)) as model,
    ):
        board = Chip(Link(simulated.open(), timeout_s=0.3, attempts=3))
        sent = []

        def stop_in_the_middle(done, cells):
            sent.append(done)
            if done > cells // 2:
                os.kill(simulated.pid, signal.SIGSTOP)

        with pytest.raises(LinkTimeoutError, match=r"^The board did not answer MAP in 3 attempts"):
            board.upload_map(heights, progress=stop_in_the_middle)
        os.kill(simulated.pid, signal.SIGCONT)
        resumed = []
        board.update_map(heights, progress=lambda done, cells: resumed.append((done, cells)))
        assert resumed[-1] == (edge * edge - sent[-1],) * 2
        model.upload_map(heights)
        check_the_same(board, model)
