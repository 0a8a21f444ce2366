# amaranth: UnusedElaboratable=no
"""Registers in a row delay a value by as many cycles."""

import pytest
from amaranth.hdl import Const, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.logic import delay_line
from tests.support.gateware.streams import simulate


class Delayed(wiring.Component):
    """A value of 8 bits and the same some cycles later."""

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
