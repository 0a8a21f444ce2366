# amaranth: UnusedElaboratable=no
"""Sizes of the two-tier build's units: readable, and checked."""

import pytest

from pathgene.hdl.feasibility.two_tier.altitude_comparator import AltitudeComparator
from pathgene.hdl.feasibility.two_tier.cell_walker import CellWalker
from pathgene.hdl.feasibility.two_tier.coarse_map import CoarseMap
from pathgene.hdl.feasibility.two_tier.segment_setup import TwoTierSegmentSetup
from tests.support.gateware.wrong_sizes import check_sizes


ONE_MAP = {"coordinate_bits": 5, "altitude_bits": 4, "segment_bits": 3}
TWO_MAPS = {"coordinate_bits": 5, "coarse_bits": 1, "altitude_bits": 4}
LIMITS = {
    "altitude_bits": ("Altitude width", 1),
    "segment_bits": ("Segment width", 1),
    "detailed_segments": ("Detailed segments", 1),
    "memory_latency": ("Memory latency", 1, 2),
    "scan_latency": ("Latency of a scan", 1),
}


@pytest.mark.parametrize(
    ("unit", "sizes"),
    [(CellWalker, ONE_MAP), (AltitudeComparator, {**ONE_MAP, "memory_latency": 1})],
)
def test_sizes_with_one_map(unit, sizes):
    limits = {**LIMITS, "coordinate_bits": ("Coordinate width", 1)}
    check_sizes(unit, sizes, {name: limits[name] for name in sizes})


@pytest.mark.parametrize(
    ("unit", "sizes"),
    [
        (TwoTierSegmentSetup, {**TWO_MAPS, "segment_bits": 3, "detailed_segments": 2}),
        (CoarseMap, {**TWO_MAPS, "memory_latency": 2, "scan_latency": 3}),
    ],
)
def test_sizes_with_two_maps(unit, sizes):
    limits = {
        **LIMITS,
        "coordinate_bits": ("Coordinate width", 2),
        "coarse_bits": ("Coarse width", 1, 4),
    }
    check_sizes(unit, sizes, {name: limits[name] for name in sizes})


@pytest.mark.parametrize("memory_latency", [1, 2])
def test_latency_of_a_comparison(memory_latency):
    assert AltitudeComparator(5, 4, 3, memory_latency).latency == memory_latency + 3
