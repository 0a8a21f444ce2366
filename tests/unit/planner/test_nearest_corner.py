"""Corners nearest to the ends of problems, compared with the definition."""

import numpy as np
import pytest

from pathgene.hdl.planner.nearest_corner import NearestCorner
from pathgene.sim.model.planner.definition.score import corner_of
from tests.support.gateware.streams import simulate
from tests.support.planner.cases import LARGE, SMALL, any_record
from tests.support.planner.population import corner


@pytest.mark.parametrize("config", [SMALL, LARGE], ids=["small", "large"])
def test_matches_the_definition(config):
    rng = np.random.default_rng(1)
    dut = NearestCorner(config.coordinate_bits, config.altitude_bits)
    clamped = 0

    async def bench(ctx):
        nonlocal clamped
        for _ in range(300):
            record = any_record(config, rng)
            for end in ("start", "goal"):
                position = {
                    name: getattr(record, f"{end}_{name}") for name in ("x", "y", "altitude")
                }
                ctx.set(dut.position, position)
                ctx.set(dut.limits, corner((record.x_limit, record.y_limit, 0)))
                await ctx.tick()
                found = ctx.get(dut.corner)
                assert (found.x, found.y, found.altitude) == corner_of(record, end)
                clamped += found.x == record.x_limit

    simulate(dut, bench)
    assert 0 < clamped < 600
