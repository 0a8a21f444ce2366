# amaranth: UnusedElaboratable=no
"""Limits of a run: counters, parts of an island, and the cycle in which a limit is reached."""

import random

import pytest

from pathgene.hdl.planner.run_control import RunLimits
from tests.support.gateware.streams import simulate


SHARE_BITS = 5


class Bench:
    """A unit of counters of ``bits``, and its numbers cycle by cycle."""

    def __init__(self, bits):
        self.dut = RunLimits(bits, SHARE_BITS)

    async def launch(self, ctx, cycles, generations, share):
        dut = self.dut
        ctx.set(dut.most_cycles, cycles)
        ctx.set(dut.most_generations, generations)
        ctx.set(dut.share, share)
        await self.pulse(ctx, dut.launch)
        ctx.set(dut.running, 1)

    async def pulse(self, ctx, signal):
        ctx.set(signal, 1)
        await ctx.tick()
        ctx.set(signal, 0)


@pytest.mark.parametrize("bits", [6, 32])
def test_parts_of_islands(bits):
    bench, rng, most = Bench(bits), random.Random(bits), (1 << bits) - 1
    dut = bench.dut

    def number():
        return rng.choice([0, most, rng.randrange(most + 1)])

    async def run(ctx):
        for _ in range(200):
            cycles, generations, share = number(), number(), rng.choice([0, 16, 31, 13])
            await bench.launch(ctx, cycles, generations, share)
            bred = rng.randrange(5)
            for _ in range(bred):
                await bench.pulse(ctx, dut.bred)
            await ctx.tick().repeat(rng.randrange(1, 40))
            now = ctx.get(dut.cycles)
            await bench.pulse(ctx, dut.split)
            for _ in range(SHARE_BITS):
                assert ctx.get(dut.splitting)
                await ctx.tick()
            assert not ctx.get(dut.splitting)
            begun = ctx.get(dut.cycles)
            assert begun == min(now + 1 + SHARE_BITS, most)
            limit = min(begun + (max(cycles - now, 0) * share >> SHARE_BITS), most)
            limit_of_generations = min(bred + (generations * share >> SHARE_BITS), most)
            await bench.pulse(ctx, dut.aim)
            await ctx.tick()
            for _ in range(10):
                # By the numbers of the previous cycle.
                before = min(ctx.get(dut.cycles), most), ctx.get(dut.generations)
                await ctx.tick()
                reached = before[0] >= limit or before[1] >= limit_of_generations
                assert ctx.get(dut.reached) == reached
            ctx.set(dut.running, 0)

    simulate(dut, run)


def test_limits_of_the_run():
    bench = Bench(8)
    dut = bench.dut

    async def run(ctx):
        for cycles, generations, stops, waits, expected in (
            (40, 255, None, 0, 41),
            (255, 3, None, 0, 31),
            (255, 3, None, 20, 31),
            (255, 3, None, 50, 51),
            (40, 3, None, 50, 41),
            (255, 3, 35, 50, 37),
            (255, 0, None, 0, 5),
            (0, 255, None, 0, 5),
            (255, 255, 20, 0, 22),
            (255, 255, None, 0, 256),
        ):
            await bench.launch(ctx, cycles, generations, 0)
            ctx.set(dut.final, 1)
            number = 0
            while number < 5 or not ctx.get(dut.reached):
                assert ctx.get(dut.cycles) == min(number, 255)
                assert ctx.get(dut.generations) == number // 10
                ctx.set(dut.aim, number == 3)
                ctx.set(dut.bred, number % 10 == 9)
                ctx.set(dut.stop, number == stops)
                ctx.set(dut.waits, number < waits)
                await ctx.tick()
                number += 1
            assert number == expected
            ctx.set(dut.running, 0)
            ctx.set(dut.stop, 1)  # Means nothing now.
            await ctx.tick()
            ctx.set(dut.stop, 0)
            assert ctx.get(dut.cycles) == min(number, 255)

    simulate(dut, run)
