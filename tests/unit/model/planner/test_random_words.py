import pytest

from pathgene.sim.model.planner.random_words import draw, field, source, step
from pathgene.sim.model.random_source import RandomSource


@pytest.mark.parametrize("seed", [0, 1, 2**64 - 1])
def test_words_are_those_of_the_random_source(seed):
    words, expected = source(seed), RandomSource(seed)
    for _ in range(200):
        step(words)
        first, second = expected.step()
        assert (field(words, 0, 0, 32), field(words, 0, 32, 32)) == (
            first & 0xFFFFFFFF,
            first >> 32,
        )
        assert field(words, 1, 7, 9) == second >> 7 & 511
        assert draw(words, 1, 16, 24, 22) == (second >> 16 & 0xFFFFFF) * 22 >> 24


def test_seed_is_checked():
    with pytest.raises(ValueError, match=r"^Seed must be from 0 to 2\*\*64 - 1, not -1$"):
        source(-1)
