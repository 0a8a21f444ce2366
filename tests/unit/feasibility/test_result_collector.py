# amaranth: UnusedElaboratable=no
"""Sizes of the unit that sums up steps; its sums are tested with the walkers."""

from pathgene.hdl.feasibility.result_collector import ResultCollector
from tests.support.gateware.wrong_sizes import check_sizes


def test_sizes():
    sizes = {
        "coordinate_bits": 4,
        "segment_bits": 3,
        "path_cells_bits": 7,
        "verdict_places": 8,
        "count_places": 16,
    }
    limits = {
        "coordinate_bits": ("Coordinate width", 1),
        "segment_bits": ("Segment width", 1),
        "path_cells_bits": ("Width of a path's cells", 1),
        "verdict_places": ("Places for verdicts", 1),
        "count_places": ("Places for counts", 1),
    }
    check_sizes(ResultCollector, sizes, limits)
