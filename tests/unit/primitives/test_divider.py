# amaranth: UnusedElaboratable=no
"""The divider: every quotient of small widths, and extreme ones of large widths."""

import random

import pytest

from pathgene.hdl.primitives.arithmetic import Divider
from tests.support.gateware.pipelines import outputs


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
def test_large_numbers(divisor_bits, quotient_bits, count):
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
