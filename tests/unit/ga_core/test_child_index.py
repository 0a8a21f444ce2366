"""Sources of a child's waypoints: its halves, its mutation, or instead a path from the host."""

import itertools
import random

import pytest

from pathgene.hdl.config import MutationKind
from pathgene.hdl.ga_core.child_index import ChildIndex
from tests.support.gateware.streams import simulate


MOST = 7
HEAD_SIZE = MOST // 2
TAIL_SIZE = MOST - HEAD_SIZE
KINDS = (MutationKind.PERTURB, MutationKind.INSERT, MutationKind.INSERT, MutationKind.DELETE)
SIZES = {"kinds": KINDS, "min_waypoints": 2, "max_waypoints": MOST}


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
    ctx.set(dut.update, 1)
    await ctx.tick()
    ctx.set(dut.update, 0)


@pytest.mark.parametrize("number", [None, 0, 1, 2, 3])
def test_every_child(number):
    """Both halves take all lengths, and the mutation all places."""
    dut = ChildIndex(**SIZES)

    async def bench(ctx):
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

    simulate(dut, bench)


def test_rewritten_path_lies_in_order():
    dut = ChildIndex(**SIZES)
    order = [("head", at) for at in range(HEAD_SIZE)]
    order += [("tail", at) for at in range(TAIL_SIZE)]

    async def bench(ctx):
        rng = random.Random(1)
        assert ctx.get(dut.length) == SIZES["min_waypoints"]
        for length in range(2, MOST + 1):
            for number in range(len(KINDS)):
                head, tail = rng.randint(1, HEAD_SIZE), rng.randint(2, TAIL_SIZE)
                await update(ctx, dut, head, tail, number, 1)
                ctx.set(dut.rewritten_length, length)
                ctx.set(dut.rewrite, 1)
                await ctx.tick()
                ctx.set(dut.rewrite, 0)
                ctx.set(dut.rewritten_length, 0)
                assert ctx.get(dut.length) == length
                assert await sources(ctx, dut, length) == order[:length]

    simulate(dut, bench)
