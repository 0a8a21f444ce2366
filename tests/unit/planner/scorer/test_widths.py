"""Widths of a score's numbers: the maximum values fit, and no bit is spare."""

from math import isqrt

import pytest

from pathgene.hdl.planner.scorer.widths import Widths
from pathgene.hdl.protocol.planner import MAX_HALF_TURN, STEEP, turn_table
from tests.support.planner.cases import LARGE, SMALL, USUAL


CONFIGS = [SMALL, USUAL, LARGE]


@pytest.mark.parametrize("config", CONFIGS, ids=["small", "usual", "large"])
def test_greatest_values_of_a_segment(config):
    widths = Widths.of(config)
    side = (1 << config.coordinate_bits + 8) - 1
    longest = isqrt(2 * side**2)
    assert longest.bit_length() == widths.length
    assert (2 * side**2).bit_length() == widths.cross
    # The divisor of a half turn has one more.
    assert longest**2 + 2 * side**2 < 1 << widths.cross + 1
    # An arc is no longer than its two tangents.
    turns = turn_table()
    assert all(turn <= 2 * 64 * i for i, turn in enumerate(turns))
    assert max(turns) <= 2 * MAX_HALF_TURN << 12
    assert ((1 << 18) - 1) * max(turns) >> 12 < 1 << widths.arc <= 1 << widths.run


@pytest.mark.parametrize("config", CONFIGS, ids=["small", "usual", "large"])
def test_greatest_values_of_a_piece(config):
    widths = Widths.of(config)
    altitude = (1 << config.altitude_bits + 4) - 1
    length = 2 * widths.longest
    rise = (1 << 20) - 1
    for climb in (altitude, -altitude):
        up = climb * rise >> 16
        assert length**2 + up**2 <= widths.flown_square
        flown = isqrt(4 * (length**2 + up**2)) + 1 >> 1
        assert flown < 1 << widths.flown
        pull = ((1 << 16) - 1) * flown + rise * climb
        assert pull < 1 << widths.pull
        for level in (-(1 << 24), 2 * altitude + (1 << 24) - 1):
            assert abs(level) <= 1 << widths.level - 1
            cost = level * flown + max(pull, 0) * ((1 << 16) - 1)
            assert -(1 << widths.piece - 1) <= cost < 1 << widths.piece - 1
            # Cost of the path, from an entry to an exit.
            pieces = 2 * config.max_waypoints + 5
            assert abs(cost) * pieces < 1 << widths.cost - 1
    assert flown.bit_length() >= widths.flown - 1


@pytest.mark.parametrize("config", CONFIGS, ids=["small", "usual", "large"])
def test_greatest_penalties(config):
    widths = Widths.of(config)
    arcs, segments = config.max_waypoints + 2, config.max_waypoints + 3
    assert segments * widths.longest < 1 << widths.total
    # The steepest segment rises by all altitudes over no length.
    excess = 4 * ((1 << config.altitude_bits + 4) - 1)
    assert excess < 1 << widths.excess
    assert segments * (STEEP + excess) < 1 << widths.steep
    assert arcs << widths.arc < 1 << widths.steep_arcs
    assert arcs < 1 << widths.count
