"""The decoder of the host's writes to the population."""

import random

import pytest

from pathgene.hdl.ga_core.write_ports import WriteDecoder
from tests.support.gateware.streams import simulate


POPULATION = 8
SIZES = {"population": POPULATION, "waypoint_bits": 12, "max_waypoints": 5, "parts": 3}


@pytest.mark.parametrize("max_waypoints", [3, 5, 8])
def test_outputs_belong_to_the_waypoint_of_the_cycle_before(max_waypoints):
    dut = WriteDecoder(**{**SIZES, "max_waypoints": max_waypoints})
    head_size = max_waypoints // 2

    async def bench(ctx):
        rng = random.Random(max_waypoints)
        for _ in range(300):
            slot, index = rng.randrange(POPULATION), rng.randrange(max_waypoints)
            waypoint, last = rng.getrandbits(12), rng.randrange(2)
            valid, allow = rng.randrange(2), rng.randrange(2)
            ctx.set(dut.allow, allow)
            ctx.set(dut.writes.valid, valid)
            ctx.set(
                dut.writes.payload,
                {"slot": slot, "index": index, "waypoint": waypoint, "last": last},
            )
            assert ctx.get(dut.writes.ready) == allow
            assert ctx.get(dut.taken) == (valid and allow)
            await ctx.tick()
            taken = valid and allow
            assert [ctx.get(part) for part in dut.writing] == [taken] * SIZES["parts"]
            assert ctx.get(dut.completed) == (1 << slot if taken and last else 0)
            if taken:
                assert ctx.get(dut.slots) == 1 << slot
                assert ctx.get(dut.waypoint) == waypoint
                assert ctx.get(dut.length) == index + 1
                assert ctx.get(dut.in_tail) == (index >= head_size)
                assert ctx.get(dut.at) == (index if index < head_size else index - head_size)

    simulate(dut, bench)
