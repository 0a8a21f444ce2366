# amaranth: UnusedElaboratable=no
"""Sizes of the parallel build's units: readable, and checked."""

import pytest

from pathgene.hdl.feasibility.parallel.hit_locator import HitLocator
from pathgene.hdl.feasibility.parallel.lanes import Lanes
from pathgene.hdl.feasibility.parallel.reciprocal import Precision, Reciprocals
from pathgene.hdl.feasibility.parallel.segment_setup import SegmentSetup
from pathgene.hdl.feasibility.parallel.slopes import Slopes
from pathgene.hdl.feasibility.parallel.terrain_memory import TerrainMemory
from tests.support.gateware.wrong_sizes import check_sizes


WIDTHS = {"coordinate_bits": 5, "altitude_bits": 4}
UNITS = [
    (HitLocator, {"lanes": 2, "coordinate_bits": 5}),
    (Lanes, {"lane_count": 2, **WIDTHS, "segment_bits": 3}),
    (SegmentSetup, {"lanes": 2, **WIDTHS, "segment_bits": 3}),
    (Slopes, {"lanes": 2, **WIDTHS}),
    (TerrainMemory, {"lane_count": 2, **WIDTHS, "memory_latency": 2}),
]
LIMITS = {
    "coordinate_bits": ("Coordinate width", 1),
    "altitude_bits": ("Altitude width", 1),
    "segment_bits": ("Segment width", 1),
    "memory_latency": ("Memory latency", 1, 2),
}


@pytest.mark.parametrize(("unit", "sizes"), UNITS)
def test_sizes(unit, sizes):
    check_sizes(unit, sizes, {name: LIMITS[name] for name in sizes if name in LIMITS})


@pytest.mark.parametrize(("unit", "sizes"), UNITS)
def test_lanes(unit, sizes):
    (name,) = set(sizes) & {"lanes", "lane_count"}
    for count in (1, 8, 32):
        assert getattr(unit(**{**sizes, name: count}), name) == count
    for count in (0, 3, 64):
        rule = f"^Lanes must be a power of two from 1 to 32, not {count}$"
        with pytest.raises(ValueError, match=rule):
            unit(**{**sizes, name: count})
    with pytest.raises(TypeError, match=r"^Lanes must be an integer, not 2\.0$"):
        unit(**{**sizes, name: 2.0})


def test_width_of_reciprocals():
    with pytest.raises(ValueError, match=r"^Coordinate width must be 1 or more, not 0$"):
        Reciprocals(0, Precision.of(1, 3, 4))


@pytest.mark.parametrize(("lanes", "edge"), [(1, 1), (2, 1), (4, 2), (8, 4), (16, 8)])
def test_banks_along_an_edge(lanes, edge):
    assert TerrainMemory(lanes, 5, 4, 1).bank_edge == edge
