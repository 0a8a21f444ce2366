# amaranth: UnusedElaboratable=no
"""The adder that subtracts: every sum and difference of a small width."""

from itertools import product

import pytest
from amaranth.sim import Simulator

from pathgene.hdl.primitives.arithmetic import AddSubtract


@pytest.mark.parametrize("width", [1, 4])
def test_every_sum_and_difference(width):
    dut = AddSubtract(width)

    async def bench(context):
        for first, second, subtracts in product(range(1 << width), range(1 << width), range(2)):
            context.set(dut.first, first)
            context.set(dut.second, second)
            context.set(dut.subtracts, subtracts)
            await context.delay(1e-9)
            exact = first - second if subtracts else first + second
            assert context.get(dut.total) == exact % (1 << width)

    simulator = Simulator(dut)
    simulator.add_testbench(bench)
    simulator.run()
