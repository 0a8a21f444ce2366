"""Random numbers against published vectors and a plain reference."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from pathgene.host.planners.fpa.philox import philox, uniform, words

from . import reference


# Known answers of the authors' implementation (Random123, philox4x32-10).
KNOWN = [
    ((0,) * 4, (0,) * 2, (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    (
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xA4093822, 0x299F31D0),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
]


@pytest.mark.parametrize(("counter", "key", "answer"), KNOWN)
def test_known_answers(counter, key, answer):
    assert philox(*map(np.uint64, (*counter, *key))) == answer
    assert tuple(reference.philox(counter, key)) == answer


@given(st.integers(0, 2**64 - 1), st.integers(0, 2**40), st.integers(0, 2**31), st.integers(0, 999))
def test_draws_are_those_of_the_reference(seed, iteration, solution, number):
    drawn = words(np.uint64(seed), iteration, solution, number)
    assert list(drawn) == reference.draw(seed, iteration, solution, number)
    high, low, _, _ = drawn
    assert uniform(high, low) == reference.uniform(int(high), int(low))


def test_uniform_numbers_leave_out_both_ends():
    zero, top = np.uint64(0), np.uint64(0xFFFFFFFF)
    assert uniform(zero, zero) == 2.0**-53
    assert uniform(top, top) == 1 - 2.0**-53
    # The middle, where the sine of Box and Muller is 0, is left out as well.
    assert uniform(np.uint64(1 << 31), zero) == 0.5 + 2.0**-53


def test_numbers_are_uniform():
    seed = np.uint64(5)
    drawn = [
        words(seed, iteration, solution, 0) for iteration in range(50) for solution in range(100)
    ]
    numbers = [uniform(w[i], w[i + 1]) for w in drawn for i in (0, 2)]
    assert stats.kstest(numbers, "uniform").pvalue > 1e-3
