"""The check with the paper's interface: a path memory, enable, flags."""

import itertools

import numpy as np
import pytest

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.feasibility.feasibility import Feasibility
from pathgene.sim.model.checker import check_path
from pathgene.sim.model.checker_cycles import batch_cycles
from tests.support.gateware.checker_cases import ground, paths_of, random_batch, upload
from tests.support.gateware.streams import shared, simulate


CONFIG = Config(
    max_waypoints=4,
    map_size=16,
    coarse_factor=2,
    altitude_bits=6,
    checker=CheckerBuild.PARALLEL,
    lanes=4,
)
BUILDS = {
    "parallel": CONFIG,
    "two-tier": CONFIG.replace(checker=CheckerBuild.TWO_TIER, lanes=1),
}


def place(point):
    return dict(zip(("x", "y", "altitude"), point, strict=True))


@pytest.mark.parametrize("count", [False, True], ids=["first", "count"])
@pytest.mark.parametrize("config", BUILDS.values(), ids=BUILDS)
def test_equals_model(config, count):
    rng = np.random.default_rng(5)
    terrain = ground(config, rng, peaks=0.03, blocked=0.01)
    paths = paths_of(random_batch(config, rng, 24))
    dut = shared(Feasibility, config)
    memory = {}
    flags = []

    async def path_memory(ctx):
        address = 0
        while True:
            _, _, address = await ctx.tick().sample(dut.read_address)
            ctx.set(dut.waypoint, place(memory.get(address, (0, 0, 0))))

    async def bench(ctx):
        ctx.set(dut.counts.ready, 1)
        ctx.set(dut.count, count)
        for number, path in enumerate(paths):
            # A check after an upload waits for the coarse map, with its flags already low.
            waits = number % 4 == 0
            if waits:
                await upload(ctx, dut, terrain.heights[: 2 if number else None])
            aircraft, *waypoints, goal = path
            address = int(rng.integers(0, 100))
            memory.clear()
            memory.update(enumerate(waypoints, start=address))
            ctx.set(dut.path_address, address)
            await ctx.tick().repeat(2)
            assert not ctx.get(dut.busy)
            ctx.set(dut.aircraft, place(aircraft))
            ctx.set(dut.goal, place(goal))
            ctx.set(dut.waypoint_count, len(waypoints))
            ctx.set(dut.enable, 1)
            await ctx.tick()
            # From now on, only the path memory counts.
            ctx.set(dut.enable, 0)
            ctx.set(dut.aircraft, place((1, 2, 3)))
            ctx.set(dut.goal, place((3, 2, 1)))
            ctx.set(dut.waypoint_count, 3)
            ctx.set(dut.path_address, 77)
            assert not ctx.get(dut.collision | dut.clear)
            model = check_path(config, terrain, path, count)
            ((cycles, reads),) = batch_cycles(config, terrain, [path], count)
            if not count:
                elapsed = 1
                while not ctx.get(dut.collision | dut.clear):
                    assert ctx.get(dut.busy)
                    await ctx.tick()
                    elapsed += 1
                # From the cycle of `enable`, number 1 of `cycles`.
                assert waits or elapsed == cycles - 1
            while ctx.get(dut.busy):
                await ctx.tick()
            flags.append((ctx.get(dut.collision), ctx.get(dut.clear)))
            assert flags[-1] == (model.collision, model.clear)
            verdict = ctx.get(dut.verdict)
            assert (verdict.segment, verdict.x, verdict.y) == (model.segment, model.x, model.y)
            assert (verdict.cells, verdict.reads, verdict.cycles) == (model.cells, reads, cycles)
            assert verdict.entries == len(model.entries)

    simulate(dut, bench, background=[path_memory])
    assert set(flags) == set(itertools.permutations((0, 1)))
