"""Slots and lengths of the read ports from a ranking."""

import random

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.ga_core.slot_mapping import SlotMapping
from tests.support.gateware.streams import as_test, pulse, shared, simulate


CONFIG = Config()
SIZES = {
    "population": CONFIG.population,
    "elite_ports": CONFIG.elites,
    "survivor_ports": CONFIG.survivors,
    "parent_ports": CONFIG.crossovers,
    "max_waypoints": CONFIG.max_waypoints,
}
#: Cycles from the last word of a ranking to ``mapped``.
LATENCY = 4


class Bench:
    def __init__(self, ctx, dut, seed):
        self.ctx, self.dut = ctx, dut
        self.rng = random.Random(seed)
        self.order = self.rng.sample(range(CONFIG.population), CONFIG.population)
        self.parents = self.rng.choices(range(CONFIG.population), k=CONFIG.crossovers)
        self.survivors = self.rng.sample(range(CONFIG.elites, CONFIG.population), CONFIG.survivors)
        self.lengths = self.rng.choices(range(2, CONFIG.max_waypoints + 1), k=CONFIG.population)
        ctx.set(dut.allow, 1)
        ctx.set(dut.parents, self.parents)
        ctx.set(dut.survivors, self.survivors)
        for port, length in zip(dut.lengths, self.lengths, strict=True):
            ctx.set(port, length)

    async def rank(self, *, pause=0):
        """Stream the ranking; return True if ``mapped`` rose before its end."""
        seen = False
        for rank, slot in enumerate(self.order):
            self.ctx.set(self.dut.ranking.valid, 1)
            self.ctx.set(self.dut.ranking.payload, {"rank": rank, "slot": slot})
            seen |= self.ctx.get(self.dut.mapped)
            await self.ctx.tick()
            self.ctx.set(self.dut.ranking.valid, 0)
            # A word without `valid` is ignored.
            self.ctx.set(self.dut.ranking.payload, {"rank": 0, "slot": 31})
            for _ in range(pause):
                seen |= self.ctx.get(self.dut.mapped)
                await self.ctx.tick()
        return seen

    def check(self):
        ranks = [*range(CONFIG.elites), *self.survivors, *self.parents]
        for port, rank in zip(self.dut.carried, ranks, strict=True):
            carried = self.ctx.get(port)
            slot = self.order[rank]
            assert (carried.slot, carried.length) == (slot, self.lengths[slot])
            assert carried.select == 1 << slot


def run_bench(function):
    dut = shared(SlotMapping, **SIZES)

    async def testbench(ctx):
        await function(ctx, dut)

    simulate(dut, testbench)


@pytest.mark.parametrize("pause", [0, 2])
@as_test(run_bench)
async def test_ports_have_the_slots_of_their_ranks(ctx, dut, pause):
    for seed in range(3):
        unit = Bench(ctx, dut, seed)
        assert not await unit.rank(pause=pause)
        for _ in range(LATENCY - 1 - pause):
            assert not ctx.get(dut.mapped)
            await ctx.tick()
        assert ctx.get(dut.mapped)
        unit.check()
        await ctx.tick()
        assert not ctx.get(dut.mapped)


@as_test(run_bench)
async def test_clear_before_the_end(ctx, dut):
    unit = Bench(ctx, dut, 5)
    for cycles in range(LATENCY - 1):
        await unit.rank()
        for _ in range(cycles):
            await ctx.tick()
        await pulse(ctx, dut.clear)
        for _ in range(LATENCY + 2):
            assert not ctx.get(dut.mapped)
            await ctx.tick()


@as_test(run_bench)
async def test_nothing_is_accepted_unless_allowed(ctx, dut):
    ctx.set(dut.allow, 0)
    ctx.set(dut.ranking.valid, 1)
    ctx.set(dut.ranking.payload, {"rank": CONFIG.population - 1, "slot": 3})
    for _ in range(6):
        assert not ctx.get(dut.ranking.ready)
        assert not ctx.get(dut.mapped)
        await ctx.tick()
