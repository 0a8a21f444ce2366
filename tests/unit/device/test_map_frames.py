"""The frames of a chip's map, and smaller maps on it."""

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol import map_request, unpack_cells
from pathgene.host.device.map_frames import changed_parts, map_frames, padded_map
from tests.support.gateware.chips import CHECKERS


CONFIG = CHECKERS["parallel"]


@pytest.mark.parametrize("shape", [(1, 1), (5, 16), (16, 3), (16, 16)])
def test_the_rest_of_the_map_is_blocked(shape):
    heights = np.arange(np.prod(shape)).reshape(shape) % CONFIG.blocked_altitude
    padded = padded_map(heights, CONFIG)
    assert padded.dtype == np.uint16
    assert padded.shape == (16, 16)
    rows, columns = shape
    assert (padded[:rows, :columns] == heights).all()
    assert (padded == CONFIG.blocked_altitude).sum() == 16 * 16 - rows * columns


@pytest.mark.parametrize("config", [CONFIG, Config()], ids=["small", "default"])
def test_frames_write_every_cell_of_a_rectangle_once(config):
    rng = np.random.default_rng(1)
    heights = rng.integers(config.blocked_altitude + 1, size=(9, 13))
    written = np.full((config.map_size,) * 2, -1)
    header = map_request(config).size
    for payload, cells in map_frames(config, heights, 2, 3):
        values = map_request(config).unpack(payload[:header])
        rows, columns = cells
        height, width = written[cells].shape
        assert values == {"x": columns.start, "y": rows.start, "width": width, "height": height}
        assert (written[cells] == -1).all()
        told = unpack_cells(config, payload[header:])[: width * height]
        written[cells] = np.array(told).reshape(height, width)
    assert (written[3:12, 2:15] == heights).all()
    assert (written >= 0).sum() == heights.size


@pytest.mark.parametrize("config", [CONFIG, Config()], ids=["small", "default"])
@pytest.mark.parametrize("share", [0.0, 0.001, 0.05, 1.0])
def test_changes_are_in_parts_of_a_frame_each(config, share):
    rng = np.random.default_rng(2)
    changed = rng.random((config.map_size,) * 2) < share
    heights = np.zeros(changed.shape, int)
    times = np.zeros(changed.shape, int)
    for rows, columns in changed_parts(config, changed):
        ((_, cells),) = map_frames(config, heights[rows, columns], columns.start, rows.start)
        assert cells == (rows, columns)
        inside = changed[cells]
        for axis in (0, 1):
            assert inside.any(axis=axis)[[0, -1]].all()
        times[cells] += 1
    assert times.max(initial=0) <= 1
    assert (times[changed] == 1).all()
