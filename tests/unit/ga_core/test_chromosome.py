"""Reads and writes of a chromosome, and read indices of children."""

import itertools
import random

import pytest

from pathgene.hdl.config import Config, MutationKind
from pathgene.hdl.ga_core.chromosome import ChildIndex, Chromosome, ReadIndex
from tests.support.gateware.streams import on, pulse, shared, simulate


CONFIG = Config(max_waypoints=7)
INDEX_SIZES = {"max_waypoints": CONFIG.max_waypoints, "patch_count": CONFIG.patches}
SIZES = {"waypoint_bits": CONFIG.waypoint_bits, **INDEX_SIZES}


@pytest.mark.parametrize("kind", [None, "perturb", "insert", "delete"])
@on(lambda: ReadIndex(**INDEX_SIZES))
async def test_index_of_every_path_and_mutation(ctx, dut, kind):
    """The head and the path take every length, and the mutation every place."""
    ctx.set(dut.advance, 1)
    for head, tail in itertools.product(range(CONFIG.head_size + 1), repeat=2):
        length = head + tail
        for at in range(length if kind else 1):
            path = [*(("head", i) for i in range(head)), *(("tail", i) for i in range(tail))]
            match kind:
                case "perturb":
                    path[at] = ("patch", 2)
                case "insert":
                    path.insert(at + 1, ("patch", 2))
                case "delete":
                    del path[at]
            ctx.set(dut.head, head)
            ctx.set(dut.pending, {"at": at, "patch": 2, **({kind: 1} if kind else {})})
            await ctx.tick()
            seen = []
            for position in range(len(path)):
                ctx.set(dut.position, position)
                await ctx.tick()
                source = ctx.get(dut.source)
                if source.patches:
                    assert not source.head
                    assert not source.tail
                    seen.append(("patch", source.patches.bit_length() - 1))
                    assert source.patches == 1 << seen[-1][1]
                else:
                    assert source.head != source.tail
                    seen.append(("tail" if source.tail else "head", source.at))
            assert seen == path, (head, tail, at)


@on(lambda: ReadIndex(**INDEX_SIZES))
async def test_index_stays_without_advance(ctx, dut):
    ctx.set(dut.head, 3)
    await ctx.tick()
    ctx.set(dut.position, 2)
    await pulse(ctx, dut.advance)
    ctx.set(dut.position, 5)
    await ctx.tick()
    source = ctx.get(dut.source)
    assert (source.tail, source.at) == (0, 2)


def test_banks_and_halves_keep_what_is_written():
    """All places of both banks are tried; both halves are written at once while a bank is read."""
    dut = shared(Chromosome, **SIZES)
    rng = random.Random(1)
    places = range(CONFIG.max_waypoints - CONFIG.head_size)
    held = {}

    async def check(ctx, bank):
        ctx.set(dut.bank, bank)
        ctx.set(dut.advance, 1)
        for tail, at in itertools.product(range(2), places):
            ctx.set(dut.source, {"head": not tail, "tail": tail, "at": at})
            await ctx.tick()
            assert ctx.get(dut.waypoint) == held.get((bank, tail, at), 0)

    async def testbench(ctx):
        await check(ctx, 0)
        for bank in (0, 1, 0):
            ctx.set(dut.written, bank)
            for at in places:
                for tail, half in enumerate((dut.head, dut.tail)):
                    held[bank, tail, at] = rng.getrandbits(CONFIG.waypoint_bits)
                    ctx.set(half.valid, 1)
                    ctx.set(half.at, at)
                    ctx.set(half.waypoint, held[bank, tail, at])
                await ctx.tick()
            for half in (dut.head, dut.tail):
                ctx.set(half.valid, 0)
                ctx.set(half.waypoint, 1)
            await check(ctx, 0)
            await check(ctx, 1)

    simulate(dut, testbench)


@on(lambda: Chromosome(**SIZES))
async def test_patches_stand_in_for_the_halves(ctx, dut):
    ctx.set(dut.advance, 1)
    for number, patch in enumerate(dut.patches):
        ctx.set(patch, 100 + number)
    for number in range(CONFIG.patches):
        ctx.set(dut.source, {"patches": 1 << number})
        await ctx.tick()
        assert ctx.get(dut.waypoint) == 100 + number
    ctx.set(dut.advance, 0)
    ctx.set(dut.source, {"tail": 1})
    await ctx.tick()
    assert ctx.get(dut.waypoint) == 100 + CONFIG.patches - 1


MOST = 7
HEAD_SIZE = MOST // 2
TAIL_SIZE = MOST - HEAD_SIZE
KINDS = (MutationKind.PERTURB, MutationKind.INSERT, MutationKind.INSERT, MutationKind.DELETE)
CHILD_SIZES = {"kinds": KINDS, "min_waypoints": 2, "max_waypoints": MOST}


async def sources(ctx, dut, length):
    """Return the source of each waypoint of the path."""
    # The index knows the path one cycle after its length.
    await ctx.tick()
    ctx.set(dut.advance, 1)
    found = []
    for position in range(length):
        ctx.set(dut.position, position)
        await ctx.tick()
        source = ctx.get(dut.source)
        if source.patches:
            found.append(("patch", source.patches.bit_length() - 1))
        else:
            found.append(("tail" if source.tail else "head", source.at))
    ctx.set(dut.advance, 0)
    return found


async def update(ctx, dut, head, tail, number, index):
    """Make a child of these waypoints, changed by mutator ``number`` or unchanged."""
    ctx.set(dut.bred_length, head + tail)
    ctx.set(dut.applied, 0 if number is None else 1 << number)
    await ctx.tick()
    ctx.set(dut.bred_length, 0)
    ctx.set(dut.bred_head, head)
    # The other ports' changes have not been applied, or apply to other children.
    for other, port in enumerate(dut.indices):
        ctx.set(port, index if other == number else MOST - 1)
    ctx.set(dut.applied, 0b1111)
    await pulse(ctx, dut.update)


@pytest.mark.parametrize("number", [None, 0, 1, 2, 3])
@on(lambda: ChildIndex(**CHILD_SIZES))
async def test_every_child(ctx, dut, number):
    """Both halves take all lengths, and the mutation all places."""
    for head, tail in itertools.product(range(1, HEAD_SIZE + 1), range(1, TAIL_SIZE + 1)):
        bred = [("head", at) for at in range(head)]
        bred += [("tail", at) for at in range(tail)]
        for index in range(len(bred) if number is not None else 1):
            path = list(bred)
            match None if number is None else KINDS[number]:
                case MutationKind.PERTURB:
                    path[index] = ("patch", number)
                case MutationKind.INSERT:
                    path.insert(index + 1, ("patch", number))
                case MutationKind.DELETE:
                    del path[index]
            if 2 <= len(path) <= MOST:
                await update(ctx, dut, head, tail, number, index)
                assert ctx.get(dut.length) == len(path)
                assert await sources(ctx, dut, len(path)) == path


def test_rewritten_path_lies_in_order():
    dut = shared(ChildIndex, **CHILD_SIZES)
    order = [("head", at) for at in range(HEAD_SIZE)]
    order += [("tail", at) for at in range(TAIL_SIZE)]

    async def bench(ctx):
        rng = random.Random(1)
        assert ctx.get(dut.length) == CHILD_SIZES["min_waypoints"]
        for length in range(2, MOST + 1):
            for number in range(len(KINDS)):
                head, tail = rng.randint(1, HEAD_SIZE), rng.randint(2, TAIL_SIZE)
                await update(ctx, dut, head, tail, number, 1)
                ctx.set(dut.rewritten_length, length)
                await pulse(ctx, dut.rewrite)
                ctx.set(dut.rewritten_length, 0)
                assert ctx.get(dut.length) == length
                assert await sources(ctx, dut, length) == order[:length]

    simulate(dut, bench)
