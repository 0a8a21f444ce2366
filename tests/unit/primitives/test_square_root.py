# amaranth: UnusedElaboratable=no
"""Square root: every number of a small width, and the numbers near squares of a large one."""

import random
from math import isqrt

import pytest

from pathgene.hdl.primitives.arithmetic import SquareRoot
from tests.support.gateware.pipelines import outputs


def beside_squares(rng, width, count):
    """Return squares and their neighbours, the extremes first."""
    top = (1 << width) - 1
    numbers = [0, 1, 2, 3, top * top - 1, top * top, (1 << 2 * width) - 1]
    for _ in range(count):
        root = rng.getrandbits(rng.randint(1, width))
        numbers += [max(root * root - 1, 0), root * root, rng.getrandbits(2 * width)]
    return numbers


@pytest.mark.parametrize("width", range(1, 8))
def test_every_number(width):
    numbers = list(range(1 << 2 * width))
    roots = outputs(SquareRoot(width), "root", ({"radicand": number} for number in numbers))
    assert roots == [isqrt(number) for number in numbers]


@pytest.mark.parametrize(
    ("width", "count"),
    [(18, 700), (22, 700), (26, 700), pytest.param(26, 100_000, marks=pytest.mark.long)],
)
def test_large_numbers(width, count):
    numbers = beside_squares(random.Random(width), width, count)
    roots = outputs(SquareRoot(width), "root", ({"radicand": number} for number in numbers))
    assert roots == [isqrt(number) for number in numbers]


def test_latency_is_the_width():
    assert [SquareRoot(width).latency for width in (1, 22)] == [1, 22]
