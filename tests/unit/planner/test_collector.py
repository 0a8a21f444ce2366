# amaranth: UnusedElaboratable=no
"""The collector against Python's stable sort, and its cycles."""

import random

import pytest

from hdl.planner.collector import Collector
from tests.streams import put, simulate
from tests.wrong_sizes import check_sizes


SIZES = {
    "population": 8,
    "elites": 2,
    "survivors": 2,
    "islands": 2,
    "slot_bits": 6,
    "length_bits": 3,
}


class Bench:
    """A collector, its populations, and the cycles since the last pulse."""

    def __init__(self, seed, islands=2):
        self.dut = Collector(**SIZES | {"islands": islands})
        self.rng = random.Random(seed)
        self.freed = []
        # From the cycle before the pulse on: whether keys are taken, `busy` and `stored`.
        self.seen = []

    async def watch(self, ctx):
        dut = self.dut
        sampled = dut.freed, dut.evaluated.ready, dut.busy, dut.stored
        async for _, _, freed, *seen in ctx.tick().sample(*sampled):
            self.seen.append(tuple(seen))
            if freed.valid:
                self.freed.append(freed.slot)

    def members(self, count):
        """Members of few keys, each of another slot."""
        slots = self.rng.sample(range(64), count)
        return [(self.rng.choice((0, 1, (1 << 30) - 1)), slot, slot % 8) for slot in slots]

    async def give(self, ctx, members):
        for key, slot, length in members:
            await put(ctx, self.dut.evaluated, {"key": key, "slot": slot, "length": length})

    async def pulse(self, ctx, signal):
        self.seen.clear()
        ctx.set(signal, 1)
        await ctx.tick()
        ctx.set(signal, 0)

    async def end(self, ctx):
        """Wait until all is done."""
        for _ in range(100):
            await ctx.tick()
            if not ctx.get(self.dut.busy):
                await ctx.tick()
                return
        raise TimeoutError("The collector does not end")

    def cycles(self, column, value):
        """Return the cycles since the pulse in which an output has a value."""
        return [i for i, seen in enumerate(self.seen[1:]) if seen[column] == value]

    async def fill(self, ctx, island, count):
        dut = self.dut
        ctx.set(dut.fills, 1)
        ctx.set(dut.island, island)
        self.freed.clear()
        members = self.members(count)
        await self.give(ctx, members)
        await self.pulse(ctx, dut.store)
        await self.end(ctx)
        ctx.set(dut.fills, 0)
        assert self.cycles(0, 0) == list(range(1, 9))
        assert self.cycles(1, 1) == list(range(1, 11))
        ranked = _sorted(members)
        assert sorted(self.freed) == sorted(slot for _, slot, _ in ranked[8:])
        return ranked[:8]

    async def compare(self, ctx, island, population):
        dut = self.dut
        ctx.set(dut.island, island)
        for rank, expected in enumerate(population):
            ctx.set(dut.rank, rank)
            await ctx.tick()
            member = ctx.get(dut.member)
            assert (member.key, member.slot, member.length) == expected

    async def generation(self, ctx, island, population, early):
        """Collect a generation, of which some children come before the pass; check its cycles."""
        dut = self.dut
        children = self.members(4)
        stay = self.rng.sample(range(2, 8), 2)
        ctx.set(dut.island, island)
        ctx.set(dut.stay, stay)
        self.freed.clear()
        await self.give(ctx, children[:early])
        await self.pulse(ctx, dut.collect)
        await self.give(ctx, children[early:])
        # The watcher comes after this bench: it has not seen the last child's cycle yet.
        last = len(self.seen) - 1 if early < 4 else -1
        await self.end(ctx)
        # The pass lets no keys through until cycle 9.
        done = max(last, 9)
        assert self.cycles(0, 0) == sorted({*range(2, 10), *range(last + 1, done + 10)})
        assert self.cycles(2, 1) == [done + 1]
        assert self.cycles(1, 1) == list(range(1, done + 12))
        kept = {0, 1, *stay}
        assert self.freed == [population[rank][1] for rank in range(8) if rank not in kept]
        return _sorted([population[rank] for rank in sorted(kept)] + children)


def _sorted(members):
    return sorted(members, key=lambda member: member[0])


@pytest.mark.parametrize("islands", [1, 2])
def test_populations(islands):
    """First populations, generations with children before and after the pass, and merges."""
    bench = Bench(islands, islands)

    async def run(ctx):
        for turn in range(10):
            held = [
                await bench.fill(ctx, island, 8 + bench.rng.randrange(12))
                for island in range(islands)
            ]
            for number in range(10):
                island = number % islands
                held[island] = await bench.generation(ctx, island, held[island], number % 5)
                for each, population in enumerate(held):
                    await bench.compare(ctx, each, population)
            if islands > 1:
                bench.freed.clear()
                await bench.pulse(ctx, bench.dut.merge)
                await bench.end(ctx)
                assert bench.cycles(2, 1) == [18]
                assert bench.cycles(1, 1) == list(range(1, 29))
                assert bench.freed == [slot for population in held for _, slot, _ in population[4:]]
                held[0] = _sorted(held[0][:4] + held[1][:4])
                await bench.compare(ctx, 0, held[0])
                # Every other time the next first populations come at once.
                if turn % 2:
                    held[0] = await bench.generation(ctx, 0, held[0], 0)
                    await bench.compare(ctx, 0, held[0])

    simulate(bench.dut, run, background=[bench.watch])


def test_sizes():
    check_sizes(
        Collector,
        SIZES,
        {
            "survivors": ("Survivors", 1, 5),
            "islands": ("Islands", 1, 2),
            "slot_bits": ("Slot width", 1),
            "length_bits": ("Length width", 1),
        },
    )
    check_sizes(Collector, SIZES | {"survivors": 1}, {"elites": ("Elites", 0, 6)})
    with pytest.raises(
        ValueError, match=r"^Population must be a power of two from 2 to 256, not 6$"
    ):
        Collector(**SIZES | {"population": 6})
