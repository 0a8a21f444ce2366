"""The sorter, compared with Python's stable sort, and its cycles."""

import bisect
import itertools
import random

import pytest

from pathgene.hdl.planner.sorter import Sorter
from tests.support.gateware.streams import shared, simulate


SIZES = {"capacity": 5, "key_bits": 4, "tag_bits": 8}


class Bench:
    """A sorter, its expected members, and the cycle in which it should take a member."""

    def __init__(self, dut, pauses=(0,)):
        self.dut, self.gaps = dut, itertools.cycle(pauses)
        self.now = self.free = 0
        self.inside = []
        # Expected and actual, by cycles.
        self.drops, self.leaves, self.dropped, self.left = {}, {}, {}, {}

    async def tick(self, ctx):
        dut = self.dut
        emptying = ctx.get(dut.emptying)
        assert ctx.get(dut.members.ready) == (self.now >= self.free and not emptying)
        dropped, left = ctx.get(dut.dropped), ctx.get(dut.left)
        if dropped.valid:
            self.dropped[self.now] = dropped.tag
        if left.valid:
            self.left[self.now] = left.rank, left.key, left.tag
        await ctx.tick()
        self.now += 1

    async def put(self, ctx, key, late, tag):
        """Offer a member as soon as it should be taken, or some cycles later."""
        members = self.dut.members
        ctx.set(members.payload, {"key": key, "late": late, "tag": tag})
        for _ in range(next(self.gaps)):
            await self.tick(ctx)
        ctx.set(members.valid, 1)
        while self.now < self.free:
            await self.tick(ctx)
        taken = self.now
        await self.tick(ctx)
        ctx.set(members.valid, 0)
        place = bisect.bisect_right(self.inside, (key, late), key=lambda member: member[:2])
        self.free = taken + 2 + len(self.inside) - place
        self.inside.insert(place, (key, late, tag))
        for _, _, gone in self.inside[self.dut.capacity :]:
            self.drops[taken + 2] = gone
        del self.inside[self.dut.capacity :]

    async def empty(self, ctx):
        """Let all members leave."""
        dut = self.dut
        for _ in range(next(self.gaps)):
            await self.tick(ctx)
        first = max(self.now + 1, self.free)
        ctx.set(dut.empty, 1)
        await self.tick(ctx)
        ctx.set(dut.empty, 0)
        self.free = first + dut.capacity
        while self.now < self.free:
            assert ctx.get(dut.emptying)
            await self.tick(ctx)
        assert not ctx.get(dut.emptying)
        for rank, (key, _, tag) in enumerate(self.inside):
            self.leaves[first + 1 + rank] = rank, key, tag
        self.inside = []


def run(dut, rounds, pauses=(0,)):
    """Sort the members of each of ``rounds``, and compare the leaving members and their cycles."""
    bench = Bench(dut, pauses)

    async def drive(ctx):
        for members in rounds:
            for member in members:
                await bench.put(ctx, *member)
            await bench.empty(ctx)
        for _ in range(3):
            await bench.tick(ctx)

    simulate(dut, drive)
    assert bench.left == bench.leaves
    assert bench.dropped == bench.drops
    ranked = [sorted(each, key=lambda member: member[:2])[: dut.capacity] for each in rounds]
    assert [(key, tag) for _, key, tag in bench.left.values()] == [
        (key, tag) for key, _, tag in itertools.chain(*ranked)
    ]


def random_rounds(rng, capacity, key_bits, count):
    """Generations and larger first populations, with few keys or many, including both extremes."""
    top = (1 << key_bits) - 1
    for _ in range(count):
        is_first = rng.random() < 0.4
        total = capacity + (rng.randrange(3 * capacity) if is_first else 0)
        keys = [
            rng.choice((0, top, rng.randint(0, top)))
            for _ in range(3 if rng.random() < 0.5 else 99)
        ]
        yield [
            (rng.choice(keys), 1 if is_first else rng.getrandbits(1), rng.getrandbits(8))
            for _ in range(total)
        ]


@pytest.mark.parametrize("pauses", [(0,), (0, 1, 0, 3, 9)], ids=["steady", "stalled"])
@pytest.mark.parametrize(("capacity", "key_bits"), [(2, 1), (5, 4), (32, 30)])
def test_random_members(capacity, key_bits, pauses):
    rounds = list(random_rounds(random.Random(capacity), capacity, key_bits, 640 // capacity))
    assert {len(members) > capacity for members in rounds} == {False, True}
    run(Sorter(capacity, key_bits, 8), rounds, pauses)


def test_every_generation_of_three_members():
    """Keys have 2 bits and delays 1 bit, in all combinations; tags follow the order of entry."""
    members = list(itertools.product(range(4), range(2)))
    rounds = [
        [(*member, tag) for tag, member in enumerate(three)]
        for three in itertools.product(members, repeat=3)
    ]
    run(Sorter(3, 2, 2), rounds)


def test_worst_and_best_of_many():
    """Four times as many as fit come from best to worst, from worst to best, and all equal."""
    run(
        Sorter(**SIZES),
        [
            [(key, 0, key) for key in range(16)],
            [(key, 0, key) for key in reversed(range(16))],
            [(7, 0, tag) for tag in range(16)],
            [(7, tag % 2, tag) for tag in range(5)],
        ],
    )


def test_cycles():
    """As the docstring says, a member takes 2 cycles, and 1 more for each that it passes."""
    dut = shared(Sorter, 2, 4, 8)
    bench = Bench(dut)
    taken = []

    async def drive(ctx):
        for key in (5, 4, 3, 6):
            await bench.put(ctx, key, 0, key)
            taken.append(bench.now - 1)
        await bench.empty(ctx)
        await bench.tick(ctx)

    simulate(dut, drive)
    # 4 passes 5, 3 passes 5 and 4, 6 passes none and is dropped.
    assert taken == [0, 2, 5, 9]
    assert bench.dropped == {7: 5, 11: 6}
    assert bench.left == {12: (0, 3, 3), 13: (1, 4, 4)}
