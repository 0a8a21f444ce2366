"""Writes to the population: paths from the host, and paths that are kept."""

import random

import pytest

from pathgene.hdl.ga_core.write_ports import PathCopier, WriteDecoder
from tests.support.gateware.streams import shared, simulate


POPULATION = 8
SIZES = {"population": POPULATION, "waypoint_bits": 12, "max_waypoints": 5, "parts": 3}


@pytest.mark.parametrize("max_waypoints", [3, 5, 8])
def test_outputs_belong_to_the_waypoint_of_the_cycle_before(max_waypoints):
    dut = shared(WriteDecoder, **{**SIZES, "max_waypoints": max_waypoints})
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


@pytest.mark.parametrize("most", [3, 5, 8])
def test_every_length_lies_in_order(most):
    dut = shared(PathCopier, 12, most)
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

    simulate(dut, testbench)
