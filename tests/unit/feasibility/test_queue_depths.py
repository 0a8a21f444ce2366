"""The depths of the checker's queues for every length of a path."""

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.queue_depths import count_depth


@pytest.mark.parametrize(
    ("max_waypoints", "depth"), [(3, 16), (15, 16), (16, 32), (31, 32), (32, 64), (63, 64)]
)
def test_a_count_of_each_segment_waits(max_waypoints, depth):
    config = Config(max_waypoints=max_waypoints)
    assert config.max_segments == max_waypoints + 1
    assert count_depth(config) == depth
