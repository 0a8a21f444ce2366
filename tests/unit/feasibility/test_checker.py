"""Behaviour that all builds of the checker share."""

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.check_controller import CheckController
from pathgene.hdl.feasibility.checker import Checker
from pathgene.hdl.feasibility.feasibility import Feasibility
from tests.support.gateware.checker_cases import upload
from tests.support.gateware.streams import put, shared, simulate


@pytest.mark.parametrize(("build", "lanes"), [("two-tier", 1), ("parallel", 4)])
def test_busy_until_the_last_point_of_a_path_that_collides_early(build, lanes):
    """Its verdict is transferred long before; the ground under its other points must stay."""
    config = Config(
        max_waypoints=4, map_size=16, coarse_factor=4, altitude_bits=4, checker=build, lanes=lanes
    )
    dut = shared(Checker, config)
    heights = np.zeros((16, 16), dtype=int)
    heights[0, 2] = 9
    steps = []

    async def bench(ctx):
        await upload(ctx, dut, heights)
        while not ctx.get(dut.writes.ready):
            await ctx.tick()
        ctx.set(dut.verdicts.ready, 1)
        for x in (0, 5):
            await put(ctx, dut.points, {"x": x, "y": 0, "altitude": 5, "last": 0})
        while not ctx.get(dut.verdicts.valid):
            assert ctx.get(dut.busy)
            await ctx.tick()
        assert ctx.get(dut.verdicts.p.collision)
        await ctx.tick()
        steps.append("transferred")

        ctx.set(dut.writes.valid, 1)
        for _ in range(9):
            assert ctx.get(dut.busy)
            assert not ctx.get(dut.writes.ready)
            await ctx.tick()
        for x, last in ((7, 0), (9, 1)):
            assert ctx.get(dut.busy)
            await put(ctx, dut.points, {"x": x, "y": 0, "altitude": 5, "last": last})
        assert not ctx.get(dut.busy)
        assert ctx.get(dut.writes.ready)
        assert not ctx.get(dut.verdicts.valid)
        steps.append("given")

    simulate(dut, bench)
    assert steps == ["transferred", "given"]


@pytest.mark.parametrize("unit", [Checker, CheckController, Feasibility])
def test_refuses_a_chip_without_a_checker(unit):
    with pytest.raises(ValueError, match=r"^Config\.checker must name a build, not 'none'$"):
        unit(Config(checker="none"))
