# amaranth: UnusedElaboratable=no
"""The sorter against Python's stable sort."""

import itertools
import random

import pytest

from hdl.planner.sorter import Sorter
from tests.streams import put, simulate
from tests.wrong_sizes import check_sizes


SIZES = {"capacity": 5, "key_bits": 4, "tag_bits": 8}


def run(dut, rounds, pauses=(0,)):
    """Sort each of ``rounds``: ``keeps_best`` and members; return what leaves in each, in order."""
    seen = []

    async def watch(ctx):
        async for _, _, left in ctx.tick().sample(dut.left):
            if left.valid:
                seen[-1].append((left.key, left.tag))

    async def bench(ctx):
        gaps = itertools.cycle(pauses)
        for keeps_best, members in rounds:
            seen.append([])
            ctx.set(dut.keeps_best, keeps_best)
            for key, late, tag in members:
                for _ in range(next(gaps)):
                    await ctx.tick()
                await put(ctx, dut.members, {"key": key, "late": late, "tag": tag}, limit=1)
            assert not ctx.get(dut.full) or len(members) > dut.capacity
            await ctx.tick()
            assert ctx.get(dut.full)
            for _ in range(dut.capacity):
                for _ in range(next(gaps)):
                    await ctx.tick()
                ctx.set(dut.drain, 1)
                await ctx.tick()
                ctx.set(dut.drain, 0)
            # The last one leaves, and the watcher sees it after this bench.
            await ctx.tick().repeat(3)
            assert not ctx.get(dut.full)

    simulate(dut, bench, background=[watch])
    return seen


def expected(capacity, keeps_best, members):
    """Return what leaves, in order."""
    if not keeps_best:
        return [(key, tag) for key, _, tag in sorted(members, key=lambda member: member[:2])]
    inside, gone = [], []
    for key, _, tag in members:
        inside = sorted([*inside, (key, tag)], key=lambda member: member[0])
        gone += inside[capacity:]
        inside = inside[:capacity]
    return gone + inside[::-1]


def random_rounds(rng, capacity, key_bits, count):
    """Generations and first populations; few keys or many, with the least and greatest."""
    for _ in range(count):
        keeps_best = rng.random() < 0.4
        total = capacity + (rng.randrange(3 * capacity) if keeps_best else 0)
        top = (1 << key_bits) - 1
        keys = [
            rng.choice((0, top, rng.randint(0, top)))
            for _ in range(3 if rng.random() < 0.5 else 99)
        ]
        yield (
            keeps_best,
            [
                (rng.choice(keys), 0 if keeps_best else rng.getrandbits(1), rng.getrandbits(8))
                for _ in range(total)
            ],
        )


@pytest.mark.parametrize("pauses", [(0,), (0, 1, 0, 3)], ids=["steady", "stalled"])
@pytest.mark.parametrize(("capacity", "key_bits"), [(2, 1), (5, 4), (32, 30)])
def test_random_members(capacity, key_bits, pauses):
    rounds = list(random_rounds(random.Random(capacity), capacity, key_bits, 640 // capacity))
    assert {keeps_best for keeps_best, _ in rounds} == {False, True}
    seen = run(Sorter(capacity, key_bits, 8), rounds, pauses)
    assert seen == [expected(capacity, *each) for each in rounds]


def test_every_generation_of_three_members():
    """All keys and lateness of 2 bits and 1, the tags in the order of entrance."""
    members = list(itertools.product(range(4), range(2)))
    rounds = [
        (False, [(*member, tag) for tag, member in enumerate(three)])
        for three in itertools.product(members, repeat=3)
    ]
    seen = run(Sorter(3, 2, 2), rounds)
    assert seen == [expected(3, *each) for each in rounds]


def test_cycles():
    """A member leaves 2 cycles after it is let go, and after the one that pushes it out."""
    dut = Sorter(2, 4, 8)

    async def bench(ctx):
        ctx.set(dut.keeps_best, 1)
        for key in (5, 4, 3):
            assert not ctx.get(dut.full)
            await put(ctx, dut.members, {"key": key, "late": 0, "tag": key})
        assert ctx.get(dut.full)
        for drain, valid, key in ((1, 0, None), (1, 1, 5), (0, 1, 4), (0, 1, 3), (0, 0, None)):
            left = ctx.get(dut.left)
            assert (left.valid, left.key if valid else None) == (valid, key)
            ctx.set(dut.drain, drain)
            await ctx.tick()

    simulate(dut, bench)


def test_nothing_is_taken_while_members_leave():
    dut = Sorter(**SIZES)

    async def bench(ctx):
        for drain in (0, 1, 0):
            ctx.set(dut.drain, drain)
            assert ctx.get(dut.members.ready) == (not drain)
            await ctx.tick()

    simulate(dut, bench)


def test_sizes():
    check_sizes(
        Sorter,
        SIZES,
        {"capacity": ("Capacity", 2), "key_bits": ("Key width", 1), "tag_bits": ("Tag width", 1)},
    )
