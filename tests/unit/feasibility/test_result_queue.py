# amaranth: UnusedElaboratable=no
"""The queue of results: order, latency, and as many words as it has room for."""

import random
from collections import deque

import pytest

from pathgene.hdl.primitives.buffers import ResultQueue
from tests.support.gateware.streams import simulate


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
    """Filled while nothing is taken, kept full at full rate, emptied; and a word a cycle."""
    waiting, full, last = depth, 20, depth
    puts = [1] * (waiting + full) + [0] * (last + 2) + [1] * 20
    readies = [0] * waiting + [1] * (full + last + 2 + 20)
    most = run(depth, puts, readies)
    assert most[: waiting + full] == [*range(1, depth), *[depth] * (full + 1)]
    assert most[waiting + full + last + 1] == 0
    assert most[-20:] == [1] * 20
