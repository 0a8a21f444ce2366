"""Buffers of streams: every word passes once and in order, at full rate."""

import random
from collections import deque

import pytest
from amaranth import Elaboratable

from pathgene.hdl.boards.ecp5_cells import Ecp5Cells
from pathgene.hdl.primitives.buffers import MemoryQueue, ResultQueue, SkidBuffer, StreamRegister
from tests.support.gateware.streams import on, pass_through, simulate


WORDS = list(range(40))


@pytest.mark.parametrize("drive_pauses", [(0,), (0, 0, 1), (3, 0, 2, 0)])
@pytest.mark.parametrize("watch_pauses", [(0,), (1,), (0, 0, 4, 0, 1)])
def test_every_word_passes_once_and_in_order(drive_pauses, watch_pauses):
    passed = pass_through(SkidBuffer(8), WORDS, drive_pauses, watch_pauses)
    assert [word for _, word in passed] == WORDS
    if watch_pauses == (0,) == drive_pauses:
        # Words pass in the cycles in which they are offered.
        assert [cycle for cycle, _ in passed] == WORDS


@on(lambda: SkidBuffer(8))
async def test_ready_is_a_register(ctx, dut):
    """`ready` follows the output's `ready` one cycle later, and the buffer holds one word."""
    ctx.set(dut.words.valid, 1)
    ctx.set(dut.words.payload, 1)
    for ready in (1, 0, 1, 0):
        ctx.set(dut.passed.ready, ready)
        assert ctx.get(dut.words.ready)
        assert (ctx.get(dut.passed.valid), ctx.get(dut.passed.payload)) == (1, 1)
    await ctx.tick()
    ctx.set(dut.words.payload, 2)
    for ready in (1, 0, 1):
        ctx.set(dut.passed.ready, ready)
        assert not ctx.get(dut.words.ready)
        assert (ctx.get(dut.passed.valid), ctx.get(dut.passed.payload)) == (1, 1)
    await ctx.tick()
    assert ctx.get(dut.words.ready)
    assert (ctx.get(dut.passed.valid), ctx.get(dut.passed.payload)) == (1, 2)


@pytest.mark.parametrize("drive_pauses", [(0,), (0, 0, 1), (3, 0, 2, 0)])
@pytest.mark.parametrize("watch_pauses", [(0,), (1,), (0, 0, 4, 0, 1)])
def test_every_word_passes_the_register_once_and_in_order(drive_pauses, watch_pauses):
    passed = pass_through(StreamRegister(8), WORDS, drive_pauses, watch_pauses)
    assert [word for _, word in passed] == WORDS
    if watch_pauses == (0,) == drive_pauses:
        assert [cycle for cycle, _ in passed] == [cycle + 1 for cycle in WORDS]


@on(lambda: StreamRegister(8))
async def test_an_offer_does_not_depend_on_its_predecessor(ctx, dut):
    ctx.set(dut.words.valid, 1)
    ctx.set(dut.words.payload, 1)
    assert not ctx.get(dut.passed.valid)
    await ctx.tick()
    ctx.set(dut.words.valid, 0)
    ctx.set(dut.words.payload, 2)
    assert (ctx.get(dut.passed.valid), ctx.get(dut.passed.payload)) == (1, 1)


def run(depth, puts, readies):
    """Offer words as ``puts`` says, take them as ``readies`` does; compare with a plain queue."""
    dut = ResultQueue(8, depth)
    rng = random.Random(depth)
    queue, most = deque(), []

    async def bench(ctx):
        for put, ready in zip(puts, readies, strict=True):
            # The word of the previous cycle is offered, unless an earlier one waits.
            assert ctx.get(dut.words.valid) == bool(queue)
            if queue:
                assert ctx.get(dut.words.payload) == queue[0]
            ctx.set(dut.words.ready, ready)
            transferred = bool(ready and queue)
            word = rng.randrange(256)
            put = put and (len(queue) < depth or transferred)
            ctx.set(dut.put, bool(put))
            ctx.set(dut.word, word)
            await ctx.tick()
            if transferred:
                queue.popleft()
            if put:
                queue.append(word)
            most.append(len(queue))

    simulate(dut, bench)
    return most


@pytest.mark.parametrize("depth", [1, 2, 3, 8])
def test_random_pauses(depth):
    rng = random.Random(depth)
    cycles = 3000
    most = run(
        depth,
        [rng.random() < 0.5 for _ in range(cycles)],
        [rng.random() < (0.3, 0.5, 0.8)[cycle * 3 // cycles] for cycle in range(cycles)],
    )
    assert max(most) == depth
    assert min(most) == 0


@pytest.mark.parametrize("depth", [1, 2, 8])
def test_full_and_empty(depth):
    """It is filled while stalled, kept full at full rate, and emptied at a word per cycle."""
    waiting, full, last = depth, 20, depth
    puts = [1] * (waiting + full) + [0] * (last + 2) + [1] * 20
    readies = [0] * waiting + [1] * (full + last + 2 + 20)
    most = run(depth, puts, readies)
    assert most[: waiting + full] == [*range(1, depth), *[depth] * (full + 1)]
    assert most[waiting + full + last + 1] == 0
    assert most[-20:] == [1] * 20


class SavesLogic:
    """A platform whose deep queues take block RAMs, like the ULX3S-45F's platform."""

    cells = Ecp5Cells(saves_logic=True)


class OnPlatform(Elaboratable):
    """A queue as built for a platform."""

    def __init__(self, queue, platform):
        self.queue, self.platform = queue, platform

    def elaborate(self, platform):
        return self.queue.elaborate(self.platform)


@pytest.mark.parametrize(
    ("depth", "platform"), [(1, None), (3, None), (8, None), (17, SavesLogic), (44, SavesLogic)]
)
def test_random_traffic(depth, platform):
    """A word is offered in the cycle after it is put in, and until it is taken."""
    dut = MemoryQueue(8, depth)
    rng = random.Random(depth)

    async def bench(ctx):
        held, most = [], 0
        for _ in range(600 + 40 * depth):
            ready, clear = rng.random() < 0.5, rng.random() < 0.005
            # Full, empty, and full again.
            often = 0.85 if len(held) < depth and rng.random() < 0.9 else 0.3
            puts = len(held) < depth and rng.random() < often
            word = rng.getrandbits(8)
            ctx.set(dut.words.ready, ready)
            ctx.set(dut.put, puts)
            ctx.set(dut.word, word)
            ctx.set(dut.clear, clear)
            assert ctx.get(dut.words.valid) == bool(held)
            if held:
                assert ctx.get(dut.words.payload) == held[0]
                if ready:
                    held.pop(0)
            if puts:
                held.append(word)
            if clear:
                held.clear()
            most = max(most, len(held))
            await ctx.tick()
        assert most == depth

    simulate(OnPlatform(dut, platform), bench)
