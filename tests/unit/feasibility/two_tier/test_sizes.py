# amaranth: UnusedElaboratable=no
"""Sizes of the two-tier build's units: readable, and checked."""

import pytest

from hdl.feasibility.two_tier.altitude_compare import AltitudeCompare
from hdl.feasibility.two_tier.cell_walker import CellWalker
from hdl.feasibility.two_tier.coarse_map import CoarseMap
from hdl.feasibility.two_tier.segment_setup import TwoTierSegmentSetup
from tests.sizes import check_sizes


Z = ("Altitude width", 4, "1 or more", (0,))
SEGMENT = ("Segment width", 3, "1 or more", (0,))
LATENCY = ("Memory latency", 1, "from 1 to 2", (0, 3))
TWO_MAPS = {
    "coordinate_bits": ("Coordinate width", 5, "2 or more", (1,)),
    "coarse_bits": ("Coarse width", 3, "from 1 to 4", (0, 5)),
    "altitude_bits": Z,
}
ONE_MAP = {
    "coordinate_bits": ("Coordinate width", 5, "1 or more", (0,)),
    "altitude_bits": Z,
    "segment_bits": SEGMENT,
}


@pytest.mark.parametrize(
    ("unit", "sizes"),
    [
        (TwoTierSegmentSetup, TWO_MAPS | {"segment_bits": SEGMENT}),
        (CellWalker, ONE_MAP),
        (AltitudeCompare, ONE_MAP | {"memory_latency": LATENCY}),
        (
            CoarseMap,
            TWO_MAPS
            | {
                "memory_latency": LATENCY,
                "scan_latency": ("Latency of a scan", 3, "1 or more", (0,)),
            },
        ),
    ],
)
def test_sizes(unit, sizes):
    check_sizes(unit, sizes)


@pytest.mark.parametrize("memory_latency", [1, 2])
def test_latency_of_a_comparison(memory_latency):
    assert AltitudeCompare(5, 4, 3, memory_latency).latency == memory_latency + 3
