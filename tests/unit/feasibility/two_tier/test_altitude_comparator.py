# amaranth: UnusedElaboratable=no
"""Latency of the comparator, which the walker around it tests otherwise."""

import pytest

from pathgene.hdl.feasibility.two_tier.cell_walker import AltitudeComparator


@pytest.mark.parametrize("memory_latency", [1, 2])
def test_latency_of_a_comparison(memory_latency):
    assert AltitudeComparator(5, 4, 3, memory_latency).latency == memory_latency + 3
