"""Ways out of pits, and room to circle in them."""

import math

import numpy as np
import pytest

from pathgene.host.diagnosis.reach import Reach, has_room


SIDES = (50.0, 100.0)


def test_distances_on_level_ground():
    reach = Reach.of(np.zeros((4, 5)), SIDES, (1, 1), 10.0, 0.1)
    assert reach.flown_m[1, 4] == 150
    assert reach.flown_m[3, 1] == 200
    assert reach.flown_m[3, 3] == pytest.approx(2 * math.hypot(50, 100))
    assert reach.way((1, 3)).tolist() == [[1, 1], [1, 2], [1, 3]]


def test_climbs_along_its_way_alone():
    heights = np.zeros((1, 40))
    heights[0, 20:22] = 100.0
    # 20 nodes from the first are 1000 m.
    assert Reach.of(heights, SIDES, (0, 0), 50.0, 0.0500001).nodes.all()
    stopped = Reach.of(heights, SIDES, (0, 0), 50.0, 0.0499999)
    assert stopped.nodes.tolist() == [[True] * 20 + [False] * 20]


@pytest.mark.parametrize(("cells", "fits"), [(4, False), (5, False), (7, True), (9, True)])
def test_room_for_a_circle(cells, fits):
    nodes = np.zeros((20, 20), dtype=bool)
    nodes[5 : 5 + cells, 3:17] = True
    assert has_room(nodes, (50.0, 50.0), 150.0) == fits


def test_room_around_a_peak():
    nodes = np.zeros((20, 20), dtype=bool)
    nodes[5:14, 5:14] = True
    nodes[6:13, 6:13] = False
    assert has_room(nodes, (50.0, 50.0), 150.0)
    assert not has_room(nodes, (50.0, 50.0), math.inf)
