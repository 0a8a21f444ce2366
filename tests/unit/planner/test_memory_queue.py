# amaranth: UnusedElaboratable=no
"""The queue in a memory against a list."""

import random

import pytest

from hdl.planner.memory_queue import MemoryQueue
from tests.streams import simulate
from tests.wrong_sizes import check_sizes


@pytest.mark.parametrize("depth", [1, 3, 8])
def test_random_traffic(depth):
    """A word is offered in the cycle after it is put in, and until it is taken."""
    dut = MemoryQueue(8, depth)
    rng = random.Random(depth)

    async def bench(ctx):
        held, most = [], 0
        for _ in range(600):
            ready, clear = rng.random() < 0.5, rng.random() < 0.02
            puts = len(held) < depth and rng.random() < 0.6
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

    simulate(dut, bench)


def test_sizes():
    check_sizes(MemoryQueue, {"shape": 8, "depth": 4}, {"depth": ("Depth", 1)})
