"""Draws of different numbers, compared with the model."""

import itertools
import random

import pytest

from pathgene.hdl.ga_core.distinct_draw import DistinctDraw
from pathgene.sim.model import selection as model
from tests.support.gateware.streams import shared, simulate


CLEAR = "clear"
IDLE = None
LATENCY = DistinctDraw.LATENCY


def run(dut, script):
    """Drive ``CLEAR``, ``IDLE`` or raw draws cycle by cycle; return ``numbers`` in each cycle."""
    seen = []

    async def testbench(ctx):
        for entry in script:
            takes = isinstance(entry, tuple)
            ctx.set(dut.clear, entry == CLEAR)
            ctx.set(dut.take, takes)
            if takes:
                ctx.set(dut.bits, list(entry))
            seen.append(tuple(ctx.get(dut.numbers)))
            await ctx.tick()

    simulate(dut, testbench)
    return seen


def number(dut, pool, raw):
    draws = [bits * pool.left >> dut.draw_bits for bits in raw]
    return dut.first + pool.take(min(draws))


def predict(dut, script):
    """Return the expected ``numbers`` in each cycle of ``script``."""
    pool = model.DistinctDraw(dut.total)
    arrivals = {}
    for cycle, entry in enumerate(script):
        if entry == CLEAR:
            pool = model.DistinctDraw(dut.total)
            for in_flight in range(cycle, cycle + LATENCY):
                arrivals.pop(in_flight + 1, None)
        elif entry is not IDLE:
            arrivals[cycle + LATENCY] = number(dut, pool, entry)

    shown, expected = (0,) * dut.count, []
    for cycle in range(len(script)):
        if cycle in arrivals:
            shown = (*shown[1:], arrivals[cycle])
        expected.append(shown)
    return expected


# Few bits, so that every sequence of raw draws can be tried. Each d below total is reachable.
@pytest.mark.parametrize(
    ("total", "count", "draw_bits", "best_of"),
    [(5, 3, 3, 1), (4, 4, 2, 1), (3, 2, 2, 2), (2, 1, 3, 1)],
)
def test_every_sequence(total, count, draw_bits, best_of):
    dut = shared(DistinctDraw, total=total, count=count, draw_bits=draw_bits, best_of=best_of)
    raws = list(itertools.product(range(1 << draw_bits), repeat=best_of))
    sequences = list(itertools.product(raws, repeat=count))
    script = []
    for sequence in sequences:
        script += [CLEAR, *sequence, *[IDLE] * LATENCY]
    seen = run(dut, script)[count + LATENCY :: 1 + count + LATENCY]

    expected = []
    for sequence in sequences:
        pool = model.DistinctDraw(total)
        expected.append(tuple(number(dut, pool, raw) for raw in sequence))
    assert seen == expected
    assert set(seen) == set(itertools.permutations(range(total), count))


@pytest.mark.parametrize(
    ("total", "count", "first", "best_of"),
    [(22, 5, 0, 1), (30, 8, 2, 1), (30, 8, 2, 2), (12, 12, 0, 1), (250, 9, 6, 1)],
    ids=["children", "survivors", "survivors_by_rank", "all", "large"],
)
def test_every_cycle_of_a_random_script(total, count, first, best_of):
    """Draws come singly and back to back, and clears at any time."""
    rng = random.Random(total + count)
    dut = shared(DistinctDraw, total=total, count=count, draw_bits=24, first=first, best_of=best_of)
    script, taken = [], 0
    for _ in range(60):
        busy = rng.choice((0.5, 1.0))
        for _ in range(rng.randrange(2 * count + LATENCY)):
            if taken < count and rng.random() < busy:
                # A wrong product becomes visible at the ends of the range.
                raw = (0, (1 << 24) - 1, rng.getrandbits(24), rng.getrandbits(24))
                script.append(tuple(rng.choices(raw, k=best_of)))
                taken += 1
            else:
                script.append(IDLE)
        script.append(CLEAR)
        taken = 0

    seen = run(dut, script)
    assert seen == predict(dut, script)
    assert max(map(max, seen)) == first + total - 1


def test_latency():
    dut = shared(DistinctDraw, total=6, count=1, draw_bits=4)
    seen = run(dut, [(15,), *[IDLE] * LATENCY])
    assert seen == [(0,)] * LATENCY + [(5,)]
