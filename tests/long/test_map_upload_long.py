"""The whole map of the real size over the line of a simulated board."""

import numpy as np
import pytest

from hdl.config import CheckerBuild, Config
from host.board import open_board
from tests.chips import board_url


pytestmark = [pytest.mark.cosim, pytest.mark.long]

BITS_PER_BYTE = 10


@pytest.mark.parametrize(
    "config",
    [
        Config(checker=CheckerBuild.PARALLEL, clocks_per_bit=4),
        Config(checker=CheckerBuild.HIERARCHICAL, clocks_per_bit=4),
    ],
    ids=lambda config: config.checker.value,
)
def test_the_line_is_never_idle(config):
    """At most 1.11 times the clocks of the cells' bytes alone; then the chip has that map."""
    edge = config.map_size
    heights = np.random.default_rng(1).integers(0, 1 << config.altitude_bits, (edge, edge))
    with (
        open_board(board_url("sim", config)) as board,
        open_board(board_url("model", config)) as model,
    ):
        before = board.counters()
        board.upload_map(heights)
        after = board.counters()
        clocks = after["clocks"] - before["clocks"]
        line = heights.size * config.altitude_bits // 8 * BITS_PER_BYTE * config.clocks_per_bit
        assert line < clocks <= 1.11 * line
        assert board.link.traffic.frames_repeated == 0

        model.upload_map(heights)
        # Far up, so that paths get far before they collide.
        rng = np.random.default_rng(2)
        top = config.blocked_altitude
        for _ in range(20):
            x, y, z = rng.integers(0, (edge, edge, 4), (10, 3)).T
            points = (x | y << config.coordinate_bits) | (top - z) << 2 * config.coordinate_bits
            path = points.tolist()
            assert board.check_path(path, counting=True) == model.check_path(path, counting=True)
