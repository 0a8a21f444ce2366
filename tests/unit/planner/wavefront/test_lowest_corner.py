# amaranth: UnusedElaboratable=no
"""The lowest corner of a row: the first of equals, and the corners that do not count."""

import random

import pytest

from pathgene.hdl.planner.wavefront.block_map import LowestCorner
from tests.support.gateware.streams import simulate


@pytest.mark.parametrize("lanes", [1, 2, 8])
def test_random_rows(lanes):
    rng, dut = random.Random(lanes), LowestCorner(lanes, 3)
    rows = [([rng.randrange(8) for _ in range(lanes)], rng.getrandbits(lanes)) for _ in range(500)]
    found = []

    async def bench(ctx):
        for cycle in range(len(rows) + dut.latency):
            corners, counts = rows[min(cycle, len(rows) - 1)]
            for port, corner in zip(dut.corners, corners, strict=True):
                ctx.set(port, corner)
            ctx.set(dut.counts, counts)
            if cycle >= dut.latency:
                found.append(ctx.get(dut.lowest))
            await ctx.tick()

    simulate(dut, bench)
    for (corners, counts), lowest in zip(rows, found, strict=True):
        counted = [(corner, lane) for lane, corner in enumerate(corners) if counts >> lane & 1]
        assert lowest.none == (not counted)
        assert lowest.blocked == any(corner == 7 for corner, _ in counted)
        if counted:
            assert (lowest.altitude, lowest.lane) == min(counted)
