"""Fraction bits of the slopes: every length, difference and cell."""

import dataclasses

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.parallel.reciprocal import Precision, Reciprocals
from tests.support.gateware.streams import pulse, shared, simulate


LANES = (1, 2, 4, 8, 16)
FULL = Config(checker="parallel")


def precision_of(config, half_steps=False):
    return Precision.of(config.lanes, config.coordinate_bits, config.altitude_bits, half_steps)


def values(precision, lanes, n, d, fraction, k):
    """Sums of the lanes for a slope d/n; the fraction bits are ``fraction``."""
    reciprocal = precision.of_length(n)
    place, groups = k % lanes, k // lanes
    shift = precision.reciprocal - fraction
    start = place * d * reciprocal >> shift
    return start + groups * (lanes * d * reciprocal >> shift)


def minors_hold(config, lengths, precision=None):
    """Return whether every cell's minor coordinate follows the formula."""
    precision = precision or precision_of(config)
    for n in lengths:
        k = np.arange(n + 1, dtype=np.int64)
        d = np.arange(-n, n + 1, dtype=np.int64)[:, None]
        value = values(precision, config.lanes, n, d, precision.minor, k) + precision.minor_bias
        if not np.array_equal(value >> precision.minor, (2 * k * d + n) // (2 * n)):
            return False
    return True


def rises_hold(config, lengths, rises, precision=None):
    """Return whether every cell's altitude is the exact altitude rounded up."""
    precision = precision or precision_of(config)
    rises = np.asarray(rises, dtype=np.int64)[:, None]
    for n in lengths:
        k = np.arange(n + 1, dtype=np.int64)
        value = values(precision, config.lanes, n, rises, precision.rise, k) + precision.rise_bias
        if not np.array_equal(value >> precision.rise, -(-k * rises // n)):
            return False
    return True


def half_steps_hold(config, lengths, rises, precision=None):
    """Return whether every corner's altitude is the lowest within half a step, rounded down.

    The exception is the corner at the lower end, which takes the altitude of the end.
    """
    precision = precision or precision_of(config, half_steps=True)
    shift, lanes = precision.reciprocal - precision.rise, config.lanes
    rises = np.asarray(rises, dtype=np.int64)[:, None]
    for n in lengths:
        reciprocal = precision.of_length(n)
        k = np.arange(n + 1, dtype=np.int64)
        odd = 2 * (k % lanes) + np.where(rises < 0, 1, -1)
        value = (odd * rises * reciprocal >> shift + 1) + precision.rise_bias
        value += k // lanes * (lanes * rises * reciprocal >> shift)
        lowest = (2 * k * rises - abs(rises)) // (2 * n)
        at_end = np.where(rises < 0, k == n, k == 0)
        if not np.array_equal((value >> precision.rise)[~at_end], lowest[~at_end]):
            return False
        if (lowest[~at_end] < np.broadcast_to(np.minimum(rises, 0), lowest.shape)[~at_end]).any():
            return False
    return True


@pytest.mark.parametrize(
    ("map_size", "lanes"),
    [(size, lanes) for size in (8, 16, 64) for lanes in LANES if lanes <= size],
)
def test_all_slopes_of_small_maps(map_size, lanes):
    config = Config(map_size=map_size, coarse_factor=2, altitude_bits=6, lanes=lanes)
    assert minors_hold(config, range(1, map_size))
    assert rises_hold(config, range(1, map_size), range(-63, 64))
    assert half_steps_hold(config, range(1, map_size), range(-63, 64))


@pytest.mark.parametrize("lanes", LANES)
def test_steepest_and_longest_of_the_full_map(lanes):
    config = FULL.replace(lanes=lanes)
    lengths = [1, 2, 3, 255, 256, 257, *range(480, 512)]
    assert minors_hold(config, lengths)
    rises = [-4095, -4094, -2049, -2048, -1, 0, 1, 2047, 4094, 4095]
    assert rises_hold(config, lengths, rises)
    assert half_steps_hold(config, lengths, rises)


@pytest.mark.long
@pytest.mark.parametrize("lanes", LANES)
def test_all_slopes_of_the_full_map(lanes):
    config = FULL.replace(lanes=lanes)
    assert minors_hold(config, range(1, 512))
    for low in range(-4095, 4096, 512):
        rises = range(low, min(low + 512, 4096))
        assert rises_hold(config, range(1, 512), rises)
        assert half_steps_hold(config, range(1, 512), rises)


def test_three_bits_less_do_not_suffice():
    """The tests above notice an error of this size."""
    precision = precision_of(FULL)
    coarser = dataclasses.replace(precision, reciprocal=precision.reciprocal - 3)
    assert not rises_hold(FULL, range(480, 512), [4095, -4095], coarser)
    halves = precision_of(FULL, half_steps=True)
    coarser = dataclasses.replace(halves, reciprocal=halves.reciprocal - 3)
    assert not half_steps_hold(FULL, range(480, 512), [4095, -4095], coarser)
    unbiased = dataclasses.replace(precision, minor_bias=1 << precision.minor - 1)
    assert not minors_hold(FULL, range(480, 512), unbiased)


def test_precision_of_the_default():
    assert precision_of(FULL) == Precision(
        reciprocal=32, minor=17, rise=16, minor_bias=(1 << 16) + 3 * 32, rise_bias=(1 << 16) - 32
    )
    assert precision_of(FULL, half_steps=True) == Precision(
        reciprocal=33, minor=17, rise=17, minor_bias=(1 << 16) + 3 * 32, rise_bias=3 * 32
    )


def test_table():
    """Two differences of either sign; one follows after 2 cycles, and a waiting one stays."""
    config = Config(map_size=16, coarse_factor=2)
    dut = shared(Reciprocals, config.coordinate_bits, precision_of(config))
    precision = precision_of(config)

    async def bench(ctx):
        for first in range(-16, 16):
            second = 15 - abs(first)
            for chosen in (0, 1):
                ctx.set(dut.differences[0], first)
                ctx.set(dut.differences[1], second)
                await pulse(ctx, dut.load)
                ctx.set(dut.move, 1)
                ctx.set(dut.second, chosen)
                ctx.set(dut.differences[0], 1)
                await ctx.tick()
                ctx.set(dut.move, 0)
                ctx.set(dut.second, 1 - chosen)
                for _ in range(2):
                    length = abs((first, second)[chosen])
                    assert ctx.get(dut.reciprocal) == precision.of_length(length)
                    await ctx.tick()

    simulate(dut, bench)
    assert precision.of_length(0) == 0
    assert precision.of_length(1) < 1 << precision.reciprocal
