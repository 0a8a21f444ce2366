# amaranth: UnusedElaboratable=no
"""The queue in a memory against a list."""

import random

import pytest
from amaranth import Elaboratable

from pathgene.hdl.boards.ecp5_cells import Ecp5Cells
from pathgene.hdl.primitives.buffers import MemoryQueue
from tests.support.gateware.streams import simulate


class SavesLogic:
    """A platform whose deep queues take block RAMs, like the ULX3S-45F's platform."""

    cells = Ecp5Cells(saves_logic=True)


class OnPlatform(Elaboratable):
    """A queue as it is on a platform."""

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
