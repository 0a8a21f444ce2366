"""Delay lines, and multiplexers with every number of inputs."""

import pytest
from amaranth.hdl import Const, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.logic import (
    delay_line,
    multiplex,
    one_hot_multiplex,
    one_hot_multiplex_tree,
)
from tests.support.gateware.streams import simulate


class Delayed(wiring.Component):
    """A value of 8 bits, and the same value some cycles later."""

    value: In(8)
    later: Out(8)

    def __init__(self, cycles):
        self.cycles = cycles
        super().__init__()

    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.later.eq(delay_line(m, self.value, self.cycles, "value"))
        return m


@pytest.mark.parametrize("cycles", [1, 2, 5])
def test_value_of_so_many_cycles_ago(cycles):
    dut = Delayed(cycles)
    seen = []

    async def bench(ctx):
        for value in range(1, 21):
            ctx.set(dut.value, value)
            seen.append(ctx.get(dut.later))
            await ctx.tick()

    simulate(dut, bench)
    assert seen == [0] * cycles + list(range(1, 21 - cycles))


def test_no_register_without_cycles_or_bits():
    m = Module()
    value, nothing = Signal(8), Const(0, 0)
    assert delay_line(m, value, 0, "value") is value
    assert delay_line(m, nothing, 3, "nothing") is nothing


@pytest.mark.parametrize("count", [1, 2, 3, 5, 8, 11, 32])
def test_every_index(count):
    items = [Signal(6, init=40 - i, name=f"item_{i}") for i in range(count)]
    # Wider than the items require.
    index = Signal(6)
    out = Signal(6)
    m = Module()
    m.d.comb += out.eq(multiplex(index, items))

    async def testbench(ctx):
        for i in range(count):
            ctx.set(index, i)
            assert ctx.get(out) == 40 - i

    simulate(m, testbench)


@pytest.mark.parametrize("count", [1, 2, 5, 8, 9, 32])
@pytest.mark.parametrize("tree", [False, True])
def test_every_bit_of_a_selection(count, tree):
    items = [Signal(6, init=40 - i, name=f"item_{i}") for i in range(count)]
    select = Signal(count)
    out = Signal(6)
    m = Module()
    m.d.comb += out.eq(
        one_hot_multiplex_tree(m, select, items, "part")
        if tree
        else one_hot_multiplex(select, items)
    )

    async def testbench(ctx):
        assert ctx.get(out) == 0
        for i in range(count):
            ctx.set(select, 1 << i)
            assert ctx.get(out) == 40 - i

    simulate(m, testbench)
