"""The memo compared with the definition: answers, values, epochs, and cycles."""

import itertools

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.planner.walker.memo import Memo
from tests.support.gateware.streams import pulse, put, shared, simulate
from tests.support.planner.cases import any_point, corner
from tests.support.planner.plain import Memo as DefinedMemo


CONFIG = Config(map_size=8, coarse_factor=2, altitude_bits=4)
SIZES = (CONFIG.coordinate_bits, CONFIG.altitude_bits)


def segment_of(start, stop, marks=0):
    identity = {"begins": marks & 1, "last": marks >> 1 & 1, "chord": marks >> 2, "first": 0}
    return {"start": corner(start), "stop": corner(stop), "identity": identity}


def run(rows, rounds, *, epoch_bits=8, pauses=(0,), walks=(3,)):
    """Look up rounds of segments, with a clear before each but the first.

    The walker is a queue that returns each segment after some cycles, with the number of the
    segment as its value. Return for each segment whether it was answered, and its result; also
    return the clearing of the rows.
    """
    dut = shared(Memo, rows, *SIZES, epoch_bits=epoch_bits)
    answered, results, swept, flight = [], [], [], []
    segments = [segment for each in rounds for segment in each]

    async def wait(ctx):
        cycles = 0
        while ctx.get(dut.busy):
            cycles += 1
            assert not ctx.get(dut.segments.ready)
            await ctx.tick()
        swept.append(cycles)

    async def bench(ctx):
        await wait(ctx)
        gaps = itertools.cycle(pauses)
        number = 0
        for some in rounds:
            if number:
                await pulse(ctx, dut.clear)
                await wait(ctx)
            for segment in some:
                for _ in range(next(gaps)):
                    await ctx.tick()
                await put(ctx, dut.segments, segment_of(*segment, marks=number % 8))
                number += 1
            while len(results) < number:
                await ctx.tick()

    async def walker(ctx):
        delays = itertools.cycle(walks)
        while True:
            ctx.set(dut.found.ready, 1)
            while True:
                *_, valid, found = await ctx.tick().sample(dut.found.valid, dut.found.p)
                if valid:
                    break
            number = len(answered)
            start, stop = segments[number]
            assert [found.start[a] for a in ("x", "y", "altitude")] == list(start)
            assert [found.stop[a] for a in ("x", "y", "altitude")] == list(stop)
            answered.append(bool(found.identity.answered))
            identity = {
                "marks": {"begins": number & 1, "last": number >> 1 & 1, "chord": number >> 2 & 1},
                "row": found.identity.row,
                "answered": found.identity.answered,
            }
            flight.append({"valid": 1, "hits": number % 16, "margin": -(number % 16)} | {
                "identity": identity
            })  # fmt: skip
            delay = next(delays)
            if delay:
                ctx.set(dut.found.ready, 0)
                for _ in range(delay):
                    await ctx.tick()

    async def back(ctx):
        for cycle in itertools.count():
            # Some wait, so that several are in flight.
            if flight and (len(flight) > 2 or cycle % 3 == 0):
                ctx.set(dut.walked, flight.pop(0))
            else:
                ctx.set(dut.walked.valid, 0)
            await ctx.tick()

    async def collect(ctx):
        while True:
            *_, result = await ctx.tick().sample(dut.results)
            if result.valid:
                marks = result.identity
                assert marks.begins | marks.last << 1 | marks.chord << 2 == len(results) % 8
                results.append((result.hits, result.margin))

    simulate(dut, bench, background=[walker, back, collect])
    return answered, results, swept


def expected(rows, rounds):
    """Return the same from the definition."""
    answered, results = [], []
    for some in rounds:
        memo = DefinedMemo(CONFIG, rows)
        for start, stop in some:
            number = len(results)
            known = memo.get(start, stop)
            value = (number % 16, -(number % 16)) if known is None else known
            if known is None:
                memo.put(start, stop, value)
            answered.append(known is not None)
            results.append(value)
    return answered, results


def segments_of(rng, number, points=4):
    some = [any_point(CONFIG, rng) for _ in range(points)]
    pairs = [(some[a], some[b]) for a, b in rng.integers(points, size=(number, 2)).tolist()]
    # The same again, immediately and after a different one.
    for at in range(0, number - 4, 5):
        pairs[at + 1] = pairs[at]
        pairs[at + 3] = pairs[at + 1]
    return pairs


@pytest.mark.parametrize(
    ("pauses", "walks"), [((0,), (0,)), ((0, 1, 0, 4), (0,)), ((0,), (0, 0, 3, 1, 9))]
)
@pytest.mark.parametrize("rows", [0, 2, 16, 512])
def test_answers_as_the_definition_does(rows, pauses, walks):
    rng = np.random.default_rng(rows)
    rounds = [segments_of(rng, 150)]
    answered, results, _ = run(rows, rounds, pauses=pauses, walks=walks)
    assert (answered, results) == expected(rows, rounds)
    assert any(answered) == (rows > 0)


@pytest.mark.parametrize("epoch_bits", [1, 2, 3])
def test_a_new_epoch_voids_every_row(epoch_bits):
    """Epochs also work when their numbers are used up and the rows are voided one by one."""
    rng = np.random.default_rng(epoch_bits)
    some = segments_of(rng, 30)
    rounds = [some] * 9
    answered, results, swept = run(16, rounds, epoch_bits=epoch_bits, walks=(0,))
    assert (answered, results) == expected(16, rounds)
    period = (1 << epoch_bits) - 1
    assert swept == [16 if number % period == 0 else 0 for number in range(9)]


def test_a_look_up_each_cycle():
    """A look-up takes three cycles from the segment to its row."""
    dut = shared(Memo, 4, *SIZES)
    seen = []

    async def bench(ctx):
        while ctx.get(dut.busy):
            await ctx.tick()
        ctx.set(dut.found.ready, 1)
        ctx.set(dut.segments.valid, 1)
        for cycle in range(20):
            ctx.set(dut.segments.p, segment_of((cycle % 8, 0, 0), (0, 0, 0)))
            assert ctx.get(dut.segments.ready)
            if ctx.get(dut.found.valid):
                seen.append((cycle, ctx.get(dut.found.p.start.x)))
            await ctx.tick()

    simulate(dut, bench)
    assert seen == [(cycle, (cycle - 3) % 8) for cycle in range(3, 20)]


def test_a_memo_without_rows():
    assert Memo(0, 5, 4, 2).row_bits == 1
