# amaranth: UnusedElaboratable=no
"""The delay line in a memory: a word of some steps ago, in steps of any length."""

import itertools

import pytest

from pathgene.hdl.primitives.storage import MemoryDelay
from tests.support.gateware.streams import simulate


@pytest.mark.parametrize("pauses", [(0,), (1,), (0, 3, 1)])
@pytest.mark.parametrize("steps", [2, 3, 8, 17])
def test_word_of_so_many_steps_ago(steps, pauses):
    dut = MemoryDelay(8, steps)
    words = list(range(1, 80))
    seen = []

    async def bench(ctx):
        for word, pause in zip(words, itertools.cycle(pauses), strict=False):
            seen.append(ctx.get(dut.delayed))
            for _ in range(pause):
                # Only the word at the end of a step counts.
                ctx.set(dut.word, 255)
                await ctx.tick()
                assert ctx.get(dut.delayed) == seen[-1]
            ctx.set(dut.word, word)
            ctx.set(dut.step, 1)
            await ctx.tick()
            ctx.set(dut.step, 0)

    simulate(dut, bench)
    assert seen == [0] * steps + words[:-steps]
