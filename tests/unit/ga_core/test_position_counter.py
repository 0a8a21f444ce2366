# amaranth: UnusedElaboratable=no
"""Cycles and positions of a crossover."""

import random

import pytest

from pathgene.hdl.ga_core.read_ports import PositionCounter
from tests.support.gateware.streams import simulate


@pytest.mark.parametrize("most", [3, 6, 16, 20])
def test_as_many_cycles_as_the_longest_path_has_waypoints(most):
    dut = PositionCounter(ports=21, max_waypoints=most)

    async def bench(ctx):
        rng = random.Random(most)
        for longest in [2, most, 2, *range(2, most + 1)]:
            lengths = [rng.randint(2, longest) for _ in dut.lengths]
            lengths[rng.randrange(len(lengths))] = longest
            for port, length in zip(dut.lengths, lengths, strict=True):
                ctx.set(port, length)
            # Nothing passes before `begin`.
            for _ in range(rng.randint(1, 3)):
                assert not ctx.get(dut.goes_on)
                await ctx.tick()
                assert not ctx.get(dut.running)
                assert not ctx.get(dut.done)
            ctx.set(dut.begin, 1)
            assert not ctx.get(dut.goes_on)
            await ctx.tick()
            ctx.set(dut.begin, 0)
            for cycle in range(longest):
                assert ctx.get(dut.running)
                assert ctx.get(dut.following) == cycle
                assert ctx.get(dut.carrying) == (cycle > 0)
                assert ctx.get(dut.position) == max(0, cycle - 1)
                assert ctx.get(dut.goes_on) == (cycle < longest - 1)
                assert not ctx.get(dut.done)
                await ctx.tick()
            assert not ctx.get(dut.running)
            assert ctx.get(dut.carrying)
            assert ctx.get(dut.position) == longest - 1
            assert ctx.get(dut.done)
            await ctx.tick()

    simulate(dut, bench)
