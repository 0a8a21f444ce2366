"""The planner of children: draws of parents, every operator, place and size, and its cycles."""

import itertools

import numpy as np
import pytest

from pathgene.hdl.planner.child_planner import ChildPlanner, ParentDraw
from tests.support.gateware.streams import shared, simulate
from tests.support.planner.plain import bits
from tests.support.planner.population import Words, plan_of


@pytest.mark.parametrize("rank_bits", [1, 3, 5])
def test_draws(rank_bits):
    dut = shared(ParentDraw, rank_bits)
    rng = np.random.default_rng(rank_bits)
    source = Words(rng)

    async def bench(ctx):
        ctx.set(dut.words.valid, 1)
        ctx.set(dut.draws.ready, 0)
        await ctx.tick()
        assert not ctx.get(dut.words.ready)
        ctx.set(dut.on, 1)
        for _ in range(200):
            selection, mutation = source.draw()
            ctx.set(dut.words.payload, [selection, mutation])
            assert ctx.get(dut.words.ready)
            await ctx.tick()
            ctx.set(dut.words.payload, [0, 0])
            survivor = ctx.get(dut.survivor)
            assert survivor.valid
            assert survivor.bits == bits(selection, 8 * rank_bits, 24)
            ranks = [bits(selection, i * rank_bits, rank_bits) for i in range(8)]
            for wait in range(3 + int(rng.integers(3))):
                assert not ctx.get(dut.words.ready)
                assert ctx.get(dut.draws.valid) == (wait >= 2)
                await ctx.tick()
                assert not ctx.get(dut.survivor.valid)
            ctx.set(dut.draws.ready, 1)
            draw = ctx.get(dut.draws.payload)
            assert (draw.head, draw.tail) == (min(ranks[:4]), min(ranks[4:]))
            assert draw.mutation == mutation
            await ctx.tick()
            ctx.set(dut.draws.ready, 0)

    simulate(dut, bench)


SIZES = {"rank_bits": 3, "slot_bits": 6, "max_waypoints": 5, "box_cells": 4, "box_steps": 30}


def cases(sizes, rng):
    """Yield lengths of parents and a mutation word, with every length, operator, place and size."""
    lengths = itertools.cycle(itertools.product(range(2, sizes["max_waypoints"] + 1), repeat=2))
    source = Words(rng)
    for number in range(256):
        word = source.draw()[1] & ~0xFFFFF
        place, size = (int(each) for each in rng.integers((256, 16)))
        yield next(lengths), word | number | place << 8 | size << 16
        yield next(lengths), source.draw()[1]


@pytest.mark.parametrize(
    "sizes",
    [SIZES, {**SIZES, "max_waypoints": 64, "box_cells": 2048, "box_steps": 32768}],
    ids=["small", "largest"],
)
def test_plans(sizes):
    dut = shared(ChildPlanner, **sizes)
    rng = np.random.default_rng(1)

    async def bench(ctx):
        for number, (lengths, word) in enumerate(cases(sizes, rng)):
            ranks = [int(rank) for rank in rng.integers(8, size=2)]
            parents = [(int(rng.integers(64)), length) for length in lengths]
            ctx.set(dut.draws.payload, {"head": ranks[0], "tail": ranks[1], "mutation": word})
            ctx.set(dut.draws.valid, 1)
            for read, (slot, length) in enumerate(parents):
                assert ctx.get(dut.rank) == ranks[read]
                assert ctx.get(dut.draws.ready) == read
                await ctx.tick()
                ctx.set(dut.plans.ready, 0)
                ctx.set(dut.parent, {"slot": slot, "length": length})
            # The draw is no longer used, nor the member after the next cycle.
            ctx.set(dut.draws.payload, {"head": 0, "tail": 0, "mutation": 0})
            # The second read was two cycles after the beginning of the first one's cycle.
            for _ in range(6):
                assert not ctx.get(dut.plans.valid)
                assert not ctx.get(dut.draws.ready)
                await ctx.tick()
                ctx.set(dut.parent, {"slot": 0, "length": 0})
            for _ in range(int(rng.integers(3))):
                assert ctx.get(dut.plans.valid)
                assert not ctx.get(dut.draws.ready)
                await ctx.tick()
            plan = ctx.get(dut.plans.payload)
            for name, value in plan_of(sizes, *parents, word).items():
                held = plan[name]
                if name == "move":
                    held = {axis: held[axis] for axis in value}
                assert held == value, (name, number)
            # The next draw is available: its first parent is read in the cycle in which this is
            # taken.
            ctx.set(dut.plans.ready, 1)

    simulate(dut, bench)
