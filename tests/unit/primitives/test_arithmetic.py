"""Arithmetic: every result of small widths, and extreme and random ones of large widths."""

import itertools
import random
from itertools import product
from math import isqrt

import pytest
from amaranth.hdl import signed, unsigned

from pathgene.hdl.primitives.arithmetic import AddSubtract, Divider, SquareRoot, WideMultiplier
from tests.support.gateware.streams import outputs, simulate


@pytest.mark.parametrize("width", [1, 4])
def test_every_sum_and_difference(width):
    dut = AddSubtract(width)

    async def bench(context):
        for first, second, subtracts in product(range(1 << width), range(1 << width), range(2)):
            context.set(dut.first, first)
            context.set(dut.second, second)
            context.set(dut.subtracts, subtracts)
            await context.delay(1e-9)
            exact = first - second if subtracts else first + second
            assert context.get(dut.total) == exact % (1 << width)

    simulate(dut, bench)


LONG = pytest.param(42, 16, 100_000, marks=pytest.mark.long)


def divided(divisor_bits, quotient_bits, cases):
    inputs = ({"dividend": dividend, "divisor": divisor} for dividend, divisor in cases)
    return outputs(Divider(divisor_bits, quotient_bits), "quotient", inputs)


@pytest.mark.parametrize(
    ("divisor_bits", "quotient_bits"), [(1, 1), (1, 5), (5, 1), (2, 4), (4, 3), (3, 6)]
)
def test_every_quotient(divisor_bits, quotient_bits):
    cases = [
        (dividend, divisor)
        for divisor in range(1, 1 << divisor_bits)
        for dividend in range(divisor << quotient_bits)
    ]
    found = divided(divisor_bits, quotient_bits, cases)
    assert found == [dividend // divisor for dividend, divisor in cases]


@pytest.mark.parametrize(
    ("divisor_bits", "quotient_bits", "count"),
    [(36, 16, 700), (18, 17, 700), (42, 16, 700), LONG],
)
def test_quotients_of_large_numbers(divisor_bits, quotient_bits, count):
    rng = random.Random(quotient_bits)
    cases = []
    for _ in range(count):
        divisor = max(rng.getrandbits(rng.randint(1, divisor_bits)), 1)
        quotient = rng.getrandbits(quotient_bits)
        cases += [
            (quotient * divisor, divisor),
            (quotient * divisor + divisor - 1, divisor),
            (rng.randrange(divisor << quotient_bits), divisor),
        ]
    top = (1 << divisor_bits) - 1
    cases += [(0, 1), (0, top), ((top << quotient_bits) - 1, top), ((1 << quotient_bits) - 1, 1)]
    found = divided(divisor_bits, quotient_bits, cases)
    assert found == [dividend // divisor for dividend, divisor in cases]


def test_latency_is_the_width_of_the_quotient():
    assert Divider(36, 16).latency == 16


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
def test_roots_of_large_numbers(width, count):
    numbers = beside_squares(random.Random(width), width, count)
    roots = outputs(SquareRoot(width), "root", ({"radicand": number} for number in numbers))
    assert roots == [isqrt(number) for number in numbers]


def test_latency_is_the_width_of_the_root():
    assert [SquareRoot(width).latency for width in (1, 22)] == [1, 22]


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
