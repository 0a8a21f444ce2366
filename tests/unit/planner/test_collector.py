"""The collector: compared with Python's stable sort, its cycles, and its ranking while it fills."""

import bisect
import random
from dataclasses import dataclass

import pytest

from pathgene.hdl.planner.collector import Collector, Ranking
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from tests.support.gateware.streams import pulse, put, shared, simulate
from tests.support.planner.plain import Sorting


RANKING_SIZES = {"population": 8, "islands": 4, "slot_bits": 6, "length_bits": 3}


def random_members(rng, count):
    keys = [rng.getrandbits(30) for _ in range(rng.choice((3, count)))]
    return [(rng.choice(keys), rng.getrandbits(6), rng.getrandbits(3)) for _ in range(count)]


def rows_passed(members):
    """Return how many of the 8 best members the last one passes."""
    *before, last = (key for key, _, _ in members)
    best = sorted(before)[:8]
    return len(best) - bisect.bisect_right(best, last)


@pytest.mark.parametrize("is_first", [False, True], ids=["generations", "first"])
def test_populations_by_rank(is_first):
    """Populations are complete when ``busy`` falls; islands stay apart."""
    dut = shared(Ranking, **RANKING_SIZES)
    rng = random.Random(3)
    dropped = []
    seen_classes = set()

    async def watch(ctx):
        async for _, _, drop in ctx.tick().sample(dut.dropped):
            if drop.valid:
                dropped.append(drop.slot)

    async def read(ctx, island, rank):
        ctx.set(dut.read, {"island": island, "rank": rank})
        await ctx.tick()
        member = ctx.get(dut.member)
        return member.key, member.slot, member.length

    async def bench(ctx):
        populations = {}
        for number in range(30):
            members = random_members(rng, 8 + (rng.randrange(9) if is_first else 0))
            dropped.clear()
            for key, slot, length in members:
                member = {"key": key, "slot": slot, "length": length}
                late = len(populations) % 2
                await put(ctx, dut.members, {"member": member, "late": late})
            # The last one may still be inserted.
            inserting = 1 + rows_passed(members)
            pause = rng.choice((0, 3, 9))
            for cycle in range(pause):
                assert ctx.get(dut.members.ready) == (cycle >= inserting)
                await ctx.tick()
            moved = max(1, inserting - pause) - 1 + 8
            island = number % 4 if number < 4 else rng.randrange(4)
            ctx.set(dut.island, island)
            await pulse(ctx, dut.store)
            ctx.set(dut.island, (island + 1) % 4)
            ranked = sorted(members, key=lambda member: member[0])
            populations[island] = ranked[:8]
            for _ in range(moved):
                assert (ctx.get(dut.busy), ctx.get(dut.members.ready)) == (1, 0)
                await ctx.tick()
            assert (ctx.get(dut.busy), ctx.get(dut.members.ready)) == (0, 1)
            assert ctx.get(dut.feasible) == (ranked[0][0] >> VALUE_BITS == PathClass.FEASIBLE)
            seen_classes.add(ctx.get(dut.feasible))
            assert sorted(dropped) == sorted(slot for _, slot, _ in ranked[8:])
            for island, population in populations.items():
                seen = [await read(ctx, island, rank) for rank in range(8)]
                assert seen == population

    simulate(dut, bench, background=[watch])
    assert seen_classes == {0, 1}


SIZES = {
    "population": 8,
    "elites": 2,
    "survivors": 2,
    "islands": 2,
    "slot_bits": 6,
    "length_bits": 3,
}


@dataclass
class Cycle:
    """Events of a cycle: the accepted key, if any, pulses, and the outputs that depend on time."""

    key: int | None
    pulses: tuple
    fills: bool
    outputs: tuple


class Bench:
    """A collector, its populations, and all cycles."""

    def __init__(self, seed, islands=2):
        self.dut = shared(Collector, **SIZES | {"islands": islands})
        self.rng = random.Random(seed)
        self.freed = []
        self.cycles = []
        # Keys of the members that stay, of each pass.
        self.kept = []

    async def watch(self, ctx):
        dut = self.dut
        taken = dut.evaluated.valid & dut.evaluated.ready
        pulses = dut.store, dut.collect, dut.merge
        outputs = dut.evaluated.ready, dut.busy, dut.sorting, dut.stored
        sampled = dut.freed, dut.evaluated.p, taken, dut.fills, *pulses, *outputs
        async for _, _, freed, member, taken, fills, *rest in ctx.tick().sample(*sampled):
            key = member.key if taken else None
            self.cycles.append(Cycle(key, tuple(rest[:3]), bool(fills), tuple(rest[3:])))
            if freed.valid:
                self.freed.append(freed.slot)

    def expected(self):
        """Return the outputs that the docstring promises in each cycle."""
        passes = iter(self.kept)
        sorting, free, moved = Sorting(8), 0, 0
        # First cycle and ranks of the next pass; children that have arrived.
        first, ranks, came = None, 0, 0
        collecting = merging = False
        for now, cycle in enumerate(self.cycles):
            if first is not None and now >= max(first, free):
                free = now + ranks
                free += sum(1 + sorting.insert(key, late=False) for key in next(passes))
                first = None
            is_last = first is None and now >= free and (came == 4 or merging)
            stored = collecting and is_last
            yield now >= free and came < 4, collecting or now < moved, now < free, stored
            store, collect, merge = cycle.pulses
            if cycle.key is not None:
                free = now + 2 + sorting.insert(cycle.key, late=True)
                came += not cycle.fills
            if store or stored:
                moved = free = max(now + 1, free) + 8
                sorting, came, collecting, merging = Sorting(8), 0, False, False
            if collect or merge:
                first, ranks, collecting, merging = now + 2, 16 if merge else 8, True, merge

    def members(self, count):
        """Members with few different keys, each with its own slot."""
        slots = self.rng.sample(range(64), count)
        return [(self.rng.choice((0, 1, (1 << 30) - 1)), slot, slot % 8) for slot in slots]

    async def give(self, ctx, members):
        for key, slot, length in members:
            await put(ctx, self.dut.evaluated, {"key": key, "slot": slot, "length": length})

    async def end(self, ctx):
        """Wait until all is done."""
        for _ in range(200):
            await ctx.tick()
            if not ctx.get(self.dut.busy):
                return
        raise TimeoutError("The collector does not end")

    async def fill(self, ctx, island, count):
        dut = self.dut
        ctx.set(dut.fills, 1)
        ctx.set(dut.island, island)
        self.freed.clear()
        members = self.members(count)
        await self.give(ctx, members)
        # The last one may still be inserted.
        for _ in range(self.rng.choice((0, 5, 20))):
            await ctx.tick()
        await pulse(ctx, dut.store)
        await self.end(ctx)
        ctx.set(dut.fills, 0)
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
        """Collect a generation, some of whose children arrive before the pass."""
        dut = self.dut
        children = self.members(4)
        stay = self.rng.sample(range(2, 8), 2)
        ctx.set(dut.island, island)
        ctx.set(dut.stay, stay)
        self.freed.clear()
        await self.give(ctx, children[:early])
        self.kept.append([population[rank][0] for rank in sorted((0, 1, *stay))])
        await pulse(ctx, dut.collect)
        await self.give(ctx, children[early:])
        await self.end(ctx)
        # The watcher runs after this bench.
        await ctx.tick()
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
                bench.kept.append([key for population in held for key, _, _ in population[:4]])
                await pulse(ctx, bench.dut.merge)
                await bench.end(ctx)
                assert bench.freed == [slot for population in held for _, slot, _ in population[4:]]
                held[0] = _sorted(held[0][:4] + held[1][:4])
                await bench.compare(ctx, 0, held[0])
                # Every second time the next first populations follow immediately.
                if turn % 2:
                    held[0] = await bench.generation(ctx, 0, held[0], 0)
                    await bench.compare(ctx, 0, held[0])

    simulate(bench.dut, run, background=[bench.watch])
    assert [cycle.outputs for cycle in bench.cycles] == list(bench.expected())
