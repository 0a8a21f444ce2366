"""Simulations of a shared design in the tests do not affect each other."""

import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from tests.support.gateware.streams import resettable, shared, simulate


class Tally(wiring.Component):
    """A counter of cycles, and a memory that keeps its last number."""

    def __init__(self):
        super().__init__({"count": Out(8), "kept": Out(8), "on": In(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=8, depth=1, init=[7])
        write, read = memory.write_port(), memory.read_port(domain="comb")
        with m.If(self.on):
            m.d.sync += self.count.eq(self.count + 1)
        m.d.comb += [write.en.eq(self.on), write.data.eq(self.count), self.kept.eq(read.data)]
        return m


def test_each_begins_with_the_initial_values():
    """So does one after a failure."""
    dut, seen = shared(Tally), []
    assert shared(Tally) is dut
    top, _ = resettable(dut)
    assert resettable(dut)[0] is top

    async def bench(ctx):
        assert (ctx.get(dut.count), ctx.get(dut.kept), ctx.get(dut.on)) == (0, 7, 0)
        ctx.set(dut.on, 1)
        await ctx.tick().repeat(5)
        assert (ctx.get(dut.count), ctx.get(dut.kept)) == (5, 4)

    async def failing(ctx):
        await bench(ctx)
        raise ValueError("planted")

    async def watch(ctx):
        while True:
            _, _, count = await ctx.tick().sample(dut.count)
            seen.append(count)

    for design in (dut, top):
        for _ in range(2):
            simulate(design, bench, background=[watch])
        with pytest.raises(ValueError, match=r"^planted$"):
            simulate(design, failing, background=[watch])
        simulate(design, bench, background=[watch])
    # The failure comes before the background bench takes its fifth sample.
    whole = [0, 1, 2, 3, 4]
    assert seen == (whole + whole + whole[:4] + whole) * 2
