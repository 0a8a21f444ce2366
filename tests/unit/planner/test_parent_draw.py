# amaranth: UnusedElaboratable=no
"""The draw of parents: its ranks, the survivor's bits, and its cycles."""

import numpy as np
import pytest

from pathgene.hdl.planner.child_planner import ParentDraw
from tests.support.gateware.streams import simulate
from tests.support.planner.plain import bits
from tests.support.planner.population import Words


@pytest.mark.parametrize("rank_bits", [1, 3, 5])
def test_draws(rank_bits):
    dut = ParentDraw(rank_bits)
    rng = np.random.default_rng(rank_bits)
    source = Words(rng)

    async def bench(ctx):
        ctx.set(dut.words.valid, 1)
        ctx.set(dut.draws.ready, 0)
        await ctx.tick()
        assert not ctx.get(dut.words.ready)
        ctx.set(dut.on, 1)
        for _ in range(200):
            selection, mutation = source.draw()
            ctx.set(dut.words.payload, [selection, mutation])
            assert ctx.get(dut.words.ready)
            await ctx.tick()
            ctx.set(dut.words.payload, [0, 0])
            survivor = ctx.get(dut.survivor)
            assert survivor.valid
            assert survivor.bits == bits(selection, 8 * rank_bits, 24)
            ranks = [bits(selection, i * rank_bits, rank_bits) for i in range(8)]
            for wait in range(3 + int(rng.integers(3))):
                assert not ctx.get(dut.words.ready)
                assert ctx.get(dut.draws.valid) == (wait >= 2)
                await ctx.tick()
                assert not ctx.get(dut.survivor.valid)
            ctx.set(dut.draws.ready, 1)
            draw = ctx.get(dut.draws.payload)
            assert (draw.head, draw.tail) == (min(ranks[:4]), min(ranks[4:]))
            assert draw.mutation == mutation
            await ctx.tick()
            ctx.set(dut.draws.ready, 0)

    simulate(dut, bench)
