"""The multiplexers, with every number of inputs."""

import pytest
from amaranth.hdl import Module, Signal
from amaranth.sim import Simulator

from pathgene.hdl.primitives.logic import multiplex, one_hot_multiplex, one_hot_multiplex_tree


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

    simulator = Simulator(m)
    simulator.add_testbench(testbench)
    simulator.run()


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

    simulator = Simulator(m)
    simulator.add_testbench(testbench)
    simulator.run()
