"""Places of the draws in the random words."""

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.random_words import WORD_BITS, RandomWordLayout


LARGEST = Config(population=256, children=128, survivors=126)


@pytest.mark.parametrize("config", [Config(), LARGEST], ids=["default", "largest"])
def test_draws_do_not_overlap_and_fit_in_a_word(config):
    layout = RandomWordLayout(config)
    selection = [
        layout.rank_first,
        layout.rank_second,
        layout.survivor_first,
        layout.survivor_second,
    ]
    for fields in (selection, [layout.child, layout.waypoint], list(layout.offsets)):
        edges = [edge for field in fields for edge in field]
        assert edges == sorted(edges)
        assert edges[-1] <= WORD_BITS


def test_the_largest_population_fills_the_selection_word():
    assert RandomWordLayout(LARGEST).survivor_second[1] == WORD_BITS
