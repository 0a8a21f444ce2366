# amaranth: UnusedElaboratable=no
"""The ranking: populations by rank, read while the next one arrives."""

import bisect
import random

import pytest

from pathgene.hdl.planner.collector import Ranking
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from tests.support.gateware.streams import put, simulate


SIZES = {"population": 8, "islands": 4, "slot_bits": 6, "length_bits": 3}


def random_members(rng, count):
    keys = [rng.getrandbits(30) for _ in range(rng.choice((3, count)))]
    return [(rng.choice(keys), rng.getrandbits(6), rng.getrandbits(3)) for _ in range(count)]


def rows_passed(members):
    """Return how many of the members before the last one passes, of the 8 best."""
    *before, last = (key for key, _, _ in members)
    best = sorted(before)[:8]
    return len(best) - bisect.bisect_right(best, last)


@pytest.mark.parametrize("is_first", [False, True], ids=["generations", "first"])
def test_populations(is_first):
    """Populations are complete when ``busy`` falls; islands stay apart."""
    dut = Ranking(**SIZES)
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
            ctx.set(dut.store, 1)
            await ctx.tick()
            ctx.set(dut.store, 0)
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
