"""The ring buffer with commits, the delay line in a memory, the memory of a map."""

import itertools
import random

import pytest

from pathgene.hdl.primitives.storage import CommitRing, MapMemory, MemoryDelay
from tests.support.gateware.streams import pulse, simulate, watch


class Writer:
    """Driver that writes rows of a ring by number, and commits."""

    def __init__(self, dut, ctx):
        self.dut = dut
        self.ctx = ctx

    async def write(self, row, word):
        self.ctx.set(self.dut.write_enable, 1)
        self.ctx.set(self.dut.write_row, row % self.dut.depth)
        self.ctx.set(self.dut.write_data, word)
        await self.ctx.tick()
        self.ctx.set(self.dut.write_enable, 0)

    def commit(self, row):
        self.ctx.set(self.dut.committed, row % (2 * self.dut.depth))


def test_offers_a_committed_row_per_cycle():
    dut = CommitRing(8, 16)
    words = []

    async def write(ctx):
        writer = Writer(dut, ctx)
        for row in range(10):
            await writer.write(row, 100 + row)
        await ctx.tick().repeat(5)
        assert words == []
        writer.commit(8)  # In cycle 15.
        await ctx.tick().repeat(20)

    simulate(dut, write, background=[watch(dut.words, words)])
    assert words == [(15 + 2 + i, 100 + i) for i in range(8)]


def test_uncommitted_rows_can_be_rewritten_in_any_order():
    dut = CommitRing(8, 8)
    words = []

    async def write(ctx):
        writer = Writer(dut, ctx)
        for row, word in [(2, 9), (0, 9), (1, 22), (0, 11), (2, 33), (3, 9)]:
            await writer.write(row, word)
        writer.commit(3)
        await writer.write(3, 44)
        writer.commit(4)
        await ctx.tick().repeat(12)

    simulate(dut, write, background=[watch(dut.words, words)])
    assert [word for _, word in words] == [11, 22, 33, 44]


def test_wraps_and_fills_under_back_pressure():
    # A writer that uses all the space while pointers wrap many times.
    dut = CommitRing(16, 8)
    words, most = [], 0
    rng = random.Random(1)
    pauses = [rng.randrange(4) for _ in range(50)]

    async def write(ctx):
        nonlocal most
        writer = Writer(dut, ctx)
        for row in range(200):
            while True:
                used = (row - ctx.get(dut.fetched)) % (2 * dut.depth)
                if used < dut.depth:
                    break
                most = max(most, used)
                await ctx.tick()
            await writer.write(row, row)
            if rng.random() < 0.5 or used == dut.depth - 1:
                writer.commit(row + 1)
        writer.commit(200)
        await ctx.tick().repeat(40)

    simulate(dut, write, background=[watch(dut.words, words, pauses)])
    assert [word for _, word in words] == list(range(200))
    assert most == dut.depth


@pytest.mark.parametrize("pauses", [(0,), (1,), (0, 3, 1)])
@pytest.mark.parametrize("steps", [2, 3, 8, 17])
def test_word_of_so_many_steps_ago(steps, pauses):
    dut = MemoryDelay(8, steps)
    words = list(range(1, 80))
    seen = []

    async def bench(ctx):
        for word, pause in zip(words, itertools.cycle(pauses), strict=False):
            seen.append(ctx.get(dut.delayed))
            for _ in range(pause):
                # Only the word at the end of a step counts.
                ctx.set(dut.word, 255)
                await ctx.tick()
                assert ctx.get(dut.delayed) == seen[-1]
            ctx.set(dut.word, word)
            await pulse(ctx, dut.step)

    simulate(dut, bench)
    assert seen == [0] * steps + words[:-steps]


@pytest.mark.parametrize("block_rows", [4, 16], ids=["blocks", "one"])
@pytest.mark.parametrize("ports", [1, 2])
@pytest.mark.parametrize("latency", [1, 2])
def test_reads_what_was_written(latency, ports, block_rows, monkeypatch):
    monkeypatch.setattr(MapMemory, "BLOCK_ROWS", block_rows)
    dut = MapMemory(rows=16, width=5, latency=latency, ports=ports)
    rng = random.Random(latency)
    rows = [rng.randrange(32) for _ in range(16)]

    async def bench(ctx):
        for _ in range(2):
            for row in rng.sample(range(16), 16):
                ctx.set(dut.a.address, row)
                ctx.set(dut.a.write_data, rows[row])
                ctx.set(dut.a.write_enable, 1)
                await ctx.tick()
            ctx.set(dut.a.write_enable, 0)
            members = [dut.a, dut.b][:ports] if ports == 2 else [dut.a]
            asked = []
            for cycle in range(40):
                if cycle >= latency:
                    for member, row in zip(members, asked[cycle - latency], strict=True):
                        assert ctx.get(member.data) == rows[row]
                asked.append([rng.randrange(16) for _ in members])
                for member, row in zip(members, asked[-1], strict=True):
                    ctx.set(member.address, row)
                await ctx.tick()
            rows[:] = [rng.randrange(32) for _ in range(16)]

    simulate(dut, bench)
