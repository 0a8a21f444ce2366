"""Writes of paths that are kept."""

import pytest
from amaranth.sim import Simulator

from pathgene.hdl.ga_core.write_ports import PathCopier


@pytest.mark.parametrize("most", [3, 5, 8])
def test_every_length_lies_in_order(most):
    dut = PathCopier(12, most)
    head_size = most // 2
    places = [("head", at) for at in range(head_size)]
    places += [("tail", at) for at in range(most - head_size)]

    async def testbench(ctx):
        for length in range(2, most + 1):
            ctx.set(dut.length, length)
            for on in (1, 0):
                ctx.set(dut.on, on)
                written = []
                for position in range(most):
                    ctx.set(dut.position, position)
                    ctx.set(dut.waypoint, 100 + position)
                    for name in ("head", "tail"):
                        half = getattr(dut, name)
                        assert ctx.get(half.waypoint) == 100 + position
                        if ctx.get(half.valid):
                            written.append((name, ctx.get(half.at)))
                    await ctx.delay(1e-8)
                assert written == (places[:length] if on else [])

    simulator = Simulator(dut)
    simulator.add_testbench(testbench)
    simulator.run()
