"""The read index and the two halves of a slot."""

import itertools
import random

import pytest
from amaranth.sim import Simulator

from pathgene.hdl.config import Config
from pathgene.hdl.ga_core.chromosome import Chromosome, ReadIndex


CONFIG = Config(max_waypoints=7)
INDEX_SIZES = {"max_waypoints": CONFIG.max_waypoints, "patch_count": CONFIG.patches}
SIZES = {"waypoint_bits": CONFIG.waypoint_bits, **INDEX_SIZES}


def simulate(dut, testbench):
    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(testbench)
    simulator.run()


@pytest.mark.parametrize("kind", [None, "perturb", "insert", "delete"])
def test_index_of_every_path_and_mutation(kind):
    """The head and the path take every length, and the mutation every place."""
    dut = ReadIndex(**INDEX_SIZES)

    async def testbench(ctx):
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

    simulate(dut, testbench)


def test_index_stays_without_advance():
    dut = ReadIndex(**INDEX_SIZES)

    async def testbench(ctx):
        ctx.set(dut.head, 3)
        await ctx.tick()
        ctx.set(dut.position, 2)
        ctx.set(dut.advance, 1)
        await ctx.tick()
        ctx.set(dut.advance, 0)
        ctx.set(dut.position, 5)
        await ctx.tick()
        source = ctx.get(dut.source)
        assert (source.tail, source.at) == (0, 2)

    simulate(dut, testbench)


def test_banks_and_halves_keep_what_is_written():
    """All places of both banks are tried; both halves are written at once while a bank is read."""
    dut = Chromosome(**SIZES)
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


def test_patches_stand_in_for_the_halves():
    dut = Chromosome(**SIZES)

    async def testbench(ctx):
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

    simulate(dut, testbench)
