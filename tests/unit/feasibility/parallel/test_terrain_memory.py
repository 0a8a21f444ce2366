# amaranth: UnusedElaboratable=no
"""Banks of the map, which the walker around it tests otherwise."""

import pytest

from pathgene.hdl.feasibility.parallel.terrain_memory import TerrainMemory


@pytest.mark.parametrize(("lanes", "edge"), [(1, 1), (2, 1), (4, 2), (8, 4), (16, 8)])
def test_banks_along_an_edge(lanes, edge):
    assert TerrainMemory(lanes, 5, 4, 1).bank_edge == edge
