# amaranth: UnusedElaboratable=no
"""Sizes of the parallel build's units: readable, and checked."""

import pytest

from hdl.feasibility.parallel.hit_locator import HitLocator
from hdl.feasibility.parallel.lanes import Lanes
from hdl.feasibility.parallel.reciprocal import Precision, Reciprocals
from hdl.feasibility.parallel.segment_setup import SegmentSetup
from hdl.feasibility.parallel.slopes import Slopes
from hdl.feasibility.parallel.terrain_memory import TerrainMemory
from tests.sizes import check_sizes


LANES = ("Lanes", 8, "a power of two from 1 to 32", (0, 3, 64))
XY = ("Coordinate width", 5, "1 or more", (0,))
Z = ("Altitude width", 4, "1 or more", (0, -2))
SEGMENT = ("Segment width", 3, "1 or more", (0,))


@pytest.mark.parametrize(
    ("unit", "sizes"),
    [
        (HitLocator, {"lanes": LANES, "coordinate_bits": XY}),
        (
            Lanes,
            {
                "lane_count": LANES,
                "coordinate_bits": XY,
                "altitude_bits": Z,
                "segment_bits": SEGMENT,
            },
        ),
        (
            SegmentSetup,
            {"lanes": LANES, "coordinate_bits": XY, "altitude_bits": Z, "segment_bits": SEGMENT},
        ),
        (Slopes, {"lanes": LANES, "coordinate_bits": XY, "altitude_bits": Z}),
        (
            TerrainMemory,
            {
                "lane_count": LANES,
                "coordinate_bits": XY,
                "altitude_bits": Z,
                "memory_latency": ("Memory latency", 2, "from 1 to 2", (0, 3)),
            },
        ),
    ],
)
def test_sizes(unit, sizes):
    check_sizes(unit, sizes)


def test_width_of_reciprocals():
    with pytest.raises(ValueError, match=r"^Coordinate width must be 1 or more, not 0$"):
        Reciprocals(0, Precision.of(1, 3, 4))


@pytest.mark.parametrize(("lanes", "edge"), [(1, 1), (2, 1), (4, 2), (8, 4), (16, 8)])
def test_banks_along_an_edge(lanes, edge):
    assert TerrainMemory(lanes, 5, 4, 1).bank_edge == edge
