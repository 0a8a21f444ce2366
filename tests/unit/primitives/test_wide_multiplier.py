# amaranth: UnusedElaboratable=no
"""The wide multiplier: products of extreme and random factors of every number of parts."""

import itertools
import random

import pytest
from amaranth.hdl import signed, unsigned

from pathgene.hdl.primitives.arithmetic import WideMultiplier
from tests.support.gateware.pipelines import outputs


def values(shape, rng):
    """Return the extremes of a shape and of its parts, and random values."""
    low = -(1 << shape.width - 1) if shape.signed else 0
    high = low + (1 << shape.width) - 1
    parts = [(1 << bits) + more for bits in (17, 18, 36) for more in (-1, 0)]
    drawn = [rng.randint(low, high) for _ in range(6)]
    chosen = {low, high, low + 1, high - 1, 0, 1, -1, *parts, *(-part for part in parts), *drawn}
    return sorted(value for value in chosen if low <= value <= high)


@pytest.mark.parametrize(
    ("first", "second", "multipliers", "latency"),
    [
        (unsigned(1), unsigned(1), 1, 1),
        (signed(18), signed(18), 1, 1),
        (unsigned(18), unsigned(18), 1, 1),
        (signed(18), unsigned(18), 1, 1),
        (unsigned(5), signed(18), 1, 1),
        (signed(19), unsigned(3), 2, 2),
        (unsigned(24), unsigned(18), 2, 2),
        (unsigned(38), unsigned(16), 3, 3),
        (signed(26), unsigned(21), 4, 3),
        (signed(21), signed(21), 4, 3),
        (unsigned(19), unsigned(19), 4, 3),
        (signed(40), signed(37), 9, 5),
        (unsigned(54), signed(20), 6, 4),
    ],
)
def test_products(first, second, multipliers, latency):
    rng = random.Random(multipliers)
    cases = list(itertools.product(values(first, rng), values(second, rng)))
    unit = WideMultiplier(first, second)
    assert (unit.multipliers, unit.latency) == (multipliers, latency)
    found = outputs(unit, "product", ({"first": one, "second": two} for one, two in cases))
    assert found == [one * two for one, two in cases]


@pytest.mark.parametrize("shift", [1, 12, 18])
@pytest.mark.parametrize(
    ("first", "second"),
    [(signed(18), unsigned(18)), (unsigned(24), unsigned(18)), (signed(20), signed(39))],
)
def test_shifted_products(first, second, shift):
    cases = list(
        itertools.product(*(values(shape, random.Random(shift)) for shape in (first, second)))
    )
    unit = WideMultiplier(first, second, shift)
    found = outputs(unit, "product", ({"first": one, "second": two} for one, two in cases))
    assert found == [one * two >> shift for one, two in cases]


def test_every_product_of_small_factors():
    cases = list(itertools.product(range(-8, 8), range(16)))
    unit = WideMultiplier(signed(4), unsigned(4))
    found = outputs(unit, "product", ({"first": one, "second": two} for one, two in cases))
    assert found == [one * two for one, two in cases]
