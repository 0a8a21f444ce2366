"""A bank of the map: both ports, both latencies, depths of one block RAM and more."""

import random

import pytest

from pathgene.hdl.feasibility.map_memory import MapMemory
from tests.support.gateware.streams import simulate


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
