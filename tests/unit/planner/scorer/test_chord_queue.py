# amaranth: UnusedElaboratable=no
"""The queue of chords: order, latency, rate, and a queue that is full."""

import random

import pytest

from hdl.planner.scorer.chord_queue import ChordQueue
from tests.streams import simulate


def chord(number):
    ends = [{"x": number % 32, "y": number % 31, "altitude": number % 29 + end} for end in range(2)]
    return {"exists": number % 3 > 0, "ends": ends}


def taken(depth, puts, pauses):
    """Return each chord taken and its cycle; ``puts`` tells the slots in which one is put in."""
    dut = ChordQueue(5, 6, depth)
    found, slots = [], iter(puts)

    async def bench(ctx):
        number, put, wait = 0, False, next(pauses)
        for cycle in range(2 * len(puts) + 200):
            ctx.set(dut.phase, cycle % 2)
            if cycle % 2 == 0:
                put = next(slots, False)
                ctx.set(dut.put, put)
                ctx.set(dut.chord, chord(number))
                number += put
            ctx.set(dut.chords.ready, wait == 0)
            if ctx.get(dut.chords.valid) and wait == 0:
                each = ctx.get(dut.chords.payload)
                ends = [{"x": end.x, "y": end.y, "altitude": end.altitude} for end in each.ends]
                found.append((cycle, {"exists": bool(each.exists), "ends": ends}))
                wait = next(pauses)
            else:
                wait = max(wait - 1, 0)
            await ctx.tick()

    simulate(dut, bench)
    return found


def no_pauses():
    while True:
        yield 0


def test_a_chord_in_every_slot():
    found = taken(16, [True] * 60, no_pauses())
    assert [each for _, each in found] == [chord(number) for number in range(60)]
    # Five cycles from the end of a slot, then one in every slot.
    assert [cycle for cycle, _ in found] == [2 * slot + 5 for slot in range(60)]


def test_order_with_pauses_on_both_sides():
    rng = random.Random(2)
    puts = [rng.random() < 0.2 for _ in range(300)]

    def pauses():
        while True:
            yield rng.choice([0, 0, 1, 9])

    found = taken(64, puts, pauses())
    assert [each for _, each in found] == [chord(number) for number in range(sum(puts))]


def test_holds_as_many_as_it_says():
    def pauses():
        yield 150
        while True:
            yield 0

    found = taken(8, [True] * 8, pauses())
    assert [each for _, each in found] == [chord(number) for number in range(8)]


def test_rejects_other_depths():
    with pytest.raises(ValueError, match=r"^Chords must be a power of two from 2 to 32768, not 3$"):
        ChordQueue(5, 6, 3)
