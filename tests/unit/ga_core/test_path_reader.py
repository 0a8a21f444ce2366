"""Paths as a stream, from a population that is read in lockstep."""

import random

import pytest

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.ga_core.path_reader import PathReader
from tests.support.gateware.streams import simulate


CONFIG = Config(
    population=8,
    children=4,
    elites=2,
    survivors=2,
    inserts=1,
    deletes=1,
    max_waypoints=5,
    checker=CheckerBuild.NONE,
)
SIZES = {
    "slot_bits": CONFIG.slot_bits,
    "waypoint_bits": CONFIG.waypoint_bits,
    "max_waypoints": CONFIG.max_waypoints,
}
#: Cycles from a rewind until the first waypoints are in the slots.
FILLING = 1


class Slots:
    """Rewinds and steps as the population does, and delays lengths as it does."""

    def __init__(self, ctx, dut, paths):
        self.ctx, self.dut, self.paths = ctx, dut, paths
        self.position = self.filling = self.slot = self.slot_before = 0
        self.steps = self.rewind = False

    async def tick(self):
        """Advance one cycle, and act on the outputs before its edge."""
        ctx, dut = self.ctx, self.dut
        steps, rewind, slot = ctx.get(dut.steps), ctx.get(dut.rewind), ctx.get(dut.slot)
        assert not (steps and self.filling), "a step before the first waypoints are there"
        await ctx.tick()
        if self.steps:
            # The slot may have changed with the last step of a path.
            path = self.paths[self.slot_before]
            assert self.position < len(path), "a step past the end"
            ctx.set(dut.waypoint, path[self.position])
            self.position += 1
        self.filling = max(0, self.filling - 1)
        if rewind:
            self.position, self.filling = 0, FILLING
        ctx.set(dut.primes, not self.filling)
        ctx.set(dut.length, len(self.paths[self.slot]))
        self.steps, self.slot, self.slot_before = steps, slot, self.slot


def random_paths(rng):
    return [
        [rng.getrandbits(CONFIG.waypoint_bits) for _ in range(rng.randint(2, CONFIG.max_waypoints))]
        for _ in range(CONFIG.population)
    ]


async def read(ctx, dut, slots, first, count, is_ready):
    """Read paths; return them, and the cycle of each waypoint after the read is accepted."""
    ctx.set(dut.allow, 1)
    ctx.set(dut.reads.payload, {"slot": first, "count": count})
    ctx.set(dut.reads.valid, 1)
    assert ctx.get(dut.reads.ready)
    await slots.tick()
    ctx.set(dut.reads.valid, 0)
    paths, cycles = [[]], []
    for cycle in range(1, 40 * count * CONFIG.max_waypoints):
        assert ctx.get(dut.active)
        assert not ctx.get(dut.reads.ready)
        ready = is_ready()
        ctx.set(dut.waypoints.ready, ready)
        if ready and ctx.get(dut.waypoints.valid):
            word = ctx.get(dut.waypoints.payload)
            paths[-1].append(word.waypoint)
            cycles.append(cycle)
            assert not word.final or word.last
            if word.final:
                await slots.tick()
                assert not ctx.get(dut.active)
                return paths, cycles
            if word.last:
                paths.append([])
        await slots.tick()
    raise TimeoutError("The last waypoint does not come")


@pytest.mark.parametrize("eagerness", [1, 0.6, 0.1])
def test_paths_come_in_order(eagerness):
    dut = PathReader(**SIZES)

    async def bench(ctx):
        rng = random.Random(1)
        slots = Slots(ctx, dut, random_paths(rng))
        for first, count in [(0, CONFIG.population), (3, 1), (5, 3), (0, 2), (7, 1)]:
            paths, _ = await read(ctx, dut, slots, first, count, lambda: rng.random() < eagerness)
            assert paths == slots.paths[first : first + count]
            slots.paths = random_paths(rng)
            for _ in range(rng.randrange(4)):
                await slots.tick()

    simulate(dut, bench)


def test_cycles():
    """It takes 5 cycles to the first waypoint, then one per waypoint, and 3 between two paths."""
    dut = PathReader(**SIZES)

    async def bench(ctx):
        rng = random.Random(2)
        slots = Slots(ctx, dut, random_paths(rng))
        paths, cycles = await read(ctx, dut, slots, 0, CONFIG.population, lambda: True)
        expected, now = [], 5
        for path in paths:
            expected += range(now, now + len(path))
            now += len(path) + 3
        assert cycles == expected

    simulate(dut, bench)


def test_no_read_is_accepted_unless_allowed():
    dut = PathReader(**SIZES)

    async def bench(ctx):
        ctx.set(dut.reads.payload, {"slot": 0, "count": 1})
        ctx.set(dut.reads.valid, 1)
        for _ in range(3):
            assert not ctx.get(dut.reads.ready)
            await ctx.tick()
            assert not ctx.get(dut.active)
            assert not ctx.get(dut.rewind)

    simulate(dut, bench)
