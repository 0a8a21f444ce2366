"""The sampler of waypoints above the ground: reading ahead, candidates, decisions, cycles."""

import collections
import random

import pytest

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.ga_core.layouts import limits_layout, offset_layout
from pathgene.hdl.ga_core.read_ports import PEEK_LATENCY
from pathgene.hdl.ga_core.terrain_aware_sampler import TerrainAwareSampler
from tests.support.gateware.chips import TINY
from tests.support.gateware.streams import as_test, shared, simulate


SMALL = TINY.replace(
    population=16, children=8, elites=3, survivors=5, inserts=2, max_waypoints=5, box_percent=60,
    checker="parallel",
)  # fmt: skip
CONFIGS = {
    "small": SMALL,
    "default": Config(checker=CheckerBuild.PARALLEL),
    "no_redraws": SMALL.replace(redraws=0),
    "most_redraws": SMALL.replace(redraws=7, memory_latency=1),
    "two_patches": SMALL.replace(population=8, children=4, elites=1, survivors=3, inserts=1),
    "four_patches": SMALL.replace(perturbs=2, redraws=1),
}


def sizes_of(config):
    """Return the arguments of the unit in the chip of ``config``."""
    return {
        "patch_count": config.patches,
        "candidates": config.candidates,
        "crossovers": config.crossovers,
        "max_waypoints": config.max_waypoints,
        "limits_layout": limits_layout(config.coordinate_bits, config.altitude_bits),
        "offset_layout": offset_layout(config.box_cells, config.box_steps),
        "lookup_latency": config.lookup_latency,
    }


class Bench:
    """Plays the population, the selection unit and the checker."""

    def __init__(self, ctx, dut, config, rng):
        self.ctx, self.dut, self.config, self.rng = ctx, dut, config, rng
        self.ground = collections.defaultdict(lambda: rng.randint(0, config.blocked_altitude))
        self.parents = [self.path() for _ in range(config.crossovers)]
        self.offsets = []
        self.looked_up = collections.deque([None] * (config.lookup_latency - 1))
        self.peeked = collections.deque([None] * (PEEK_LATENCY - 1))
        self.peeks = 0
        self.lookups = 0

    def path(self):
        config = self.config
        return [self.rng.getrandbits(config.waypoint_bits) for _ in range(config.max_waypoints)]

    def unpacked(self, waypoint):
        bits = self.config.coordinate_bits
        mask = (1 << bits) - 1
        return waypoint & mask, waypoint >> bits & mask, waypoint >> 2 * bits

    async def tick(self):
        """Advance one cycle. Inputs that were not requested are random."""
        ctx, dut, config, rng = self.ctx, self.dut, self.config, self.rng
        if ctx.get(dut.peek):
            self.peeks += 1
            position = ctx.get(dut.peek_position)
            self.peeked.append([path[position] for path in self.parents])
        else:
            self.peeked.append(None)
        cell = None
        if ctx.get(dut.lookup_valid):
            self.lookups += 1
            cell = ctx.get(dut.lookup_x), ctx.get(dut.lookup_y)
        self.looked_up.append(cell)
        if ctx.get(dut.offset_taken):
            self.offsets.pop(0)

        await ctx.tick()
        waypoints = self.peeked.popleft() or [self.path()[0] for _ in self.parents]
        for port, waypoint in zip(dut.waypoints, waypoints, strict=True):
            ctx.set(port, waypoint)
        cell = self.looked_up.popleft()
        altitude = rng.getrandbits(config.altitude_bits) if cell is None else self.ground[cell]
        ctx.set(dut.lookup_altitude, altitude)
        self.offer()

    def offer(self):
        if self.offsets:
            axes = ("x", "y", "altitude")
            self.ctx.set(self.dut.offset, dict(zip(axes, self.offsets[0], strict=True)))

    def plan(self):
        """Plan at random; return the waypoints to be moved, and a list of the needed ones."""
        ctx, dut, rng, config = self.ctx, self.dut, self.rng, self.config
        bases = []
        for plan in dut.plans:
            parent = rng.randrange(config.crossovers)
            position = rng.randrange(config.max_waypoints)
            ctx.set(plan, {"parent": parent, "position": position})
            bases.append(self.parents[parent][position])
        needed = [number == 0 or rng.random() < 0.8 for number in range(config.patches)]
        ctx.set(dut.needed, sum(need << number for number, need in enumerate(needed)))

        def offset():
            return tuple(
                rng.choice((-box, box, rng.randint(-box, box)))
                for box in (config.box_cells, config.box_cells, config.box_steps)
            )

        self.offsets = [offset() for _ in range(config.patches * config.candidates)]
        self.offer()
        return bases, needed

    async def fetch(self):
        """Return the cycles from ``fetch`` to ``fetched``."""
        self.ctx.set(self.dut.fetch, 1)
        cycles = 0
        while not self.ctx.get(self.dut.fetched):
            await self.tick()
            self.ctx.set(self.dut.fetch, 0)
            cycles += 1
            # Reading ahead unsettles the population.
            if self.peeks:
                self.ctx.set(self.dut.settled, 0)
            assert cycles < 60
        self.ctx.set(self.dut.settled, 1)
        assert self.peeks == self.config.patches
        self.peeks = 0
        return cycles

    def expected(self, bases, needed, limits, avoid):
        """Return the effect of the candidates, one by one.

        These are the new waypoints by their patch, the redraws, and the last candidate needed.
        """
        config, found, redrawn, last = self.config, {}, 0, 0
        settled = {number for number, need in enumerate(needed) if not need}
        for n, offset in enumerate(self.offsets):
            number = n % config.patches
            if number in settled:
                continue
            last = n
            moved = zip(self.unpacked(bases[number]), offset, limits, strict=True)
            x, y, altitude = (max(0, min(value + step, limit)) for value, step, limit in moved)
            if not avoid or altitude > self.ground[x, y]:
                bits = config.coordinate_bits
                found[number] = x | y << bits | altitude << 2 * bits
                settled.add(number)
            elif n + config.patches < len(self.offsets):
                redrawn += 1
        return found, redrawn, last

    async def run(self, avoid):
        """Fetch and run once; check all decisions and their cycle. Return their effect."""
        ctx, dut, config, rng = self.ctx, self.dut, self.config, self.rng
        bases, needed = self.plan()
        limits = (
            rng.randrange(config.map_size),
            rng.randrange(config.map_size),
            rng.randrange(config.blocked_altitude),
        )
        ctx.set(dut.limits, dict(zip(("x", "y", "altitude"), limits, strict=True)))
        ctx.set(dut.avoid, avoid)
        found, redrawn, last = self.expected(bases, needed, limits, avoid)
        assert await self.fetch() == TerrainAwareSampler.latency_of(config.patches)
        for _ in range(rng.randrange(4)):
            await self.tick()

        self.lookups = 0
        ctx.set(dut.run, 1)
        cycles = 0
        while True:
            await self.tick()
            cycles += 1
            assert cycles < 100
            if ctx.get(dut.decided):
                break
        assert cycles == last + config.lookup_latency + 5
        # Further candidates change nothing.
        for _ in range(rng.choice((0, 1, 9, 40))):
            await self.tick()
        assert ctx.get(dut.decided)
        assert ctx.get(dut.found) == sum(1 << number for number in found)
        assert {number: ctx.get(dut.patches[number]) for number in found} == found
        assert ctx.get(dut.redrawn) == redrawn
        ctx.set(dut.run, 0)
        await self.tick()
        await self.tick()
        for _ in range(rng.choice((0, 3, 12))):
            await self.tick()
        assert self.lookups <= config.patches * config.candidates
        return needed, found, redrawn


def bench_of(function, config=SMALL, seed=1):
    dut = shared(TerrainAwareSampler, **sizes_of(config))

    async def testbench(ctx):
        ctx.set(dut.settled, 1)
        await function(ctx, dut, Bench(ctx, dut, config, random.Random(seed)))

    simulate(dut, testbench)


@pytest.mark.parametrize("name", CONFIGS)
def test_random_patches(name):
    config = CONFIGS[name]

    async def bench(ctx, dut, unit):
        left_out = redraws = 0
        for number in range(40):
            needed, found, redrawn = await unit.run(avoid=number % 5 > 0)
            if number % 5 == 0:
                assert len(found) == sum(needed)
                assert not redrawn
            left_out += sum(needed) - len(found)
            redraws += redrawn
        assert left_out > 0
        assert (redraws > 0) == (config.redraws > 0)

    bench_of(bench, config, seed=name)


@as_test(bench_of)
async def test_fetch_waits_until_settled(ctx, dut, unit):
    for wait in (1, 7):
        unit.plan()
        ctx.set(dut.settled, 0)
        ctx.set(dut.fetch, 1)
        await unit.tick()
        ctx.set(dut.fetch, 0)
        for _ in range(wait):
            assert not ctx.get(dut.peek)
            await unit.tick()
        ctx.set(dut.settled, 1)
        cycles = 0
        while not ctx.get(dut.fetched):
            assert ctx.get(dut.peek) == (cycles < SMALL.patches)
            await unit.tick()
            ctx.set(dut.settled, 0)
            cycles += 1
        assert cycles == TerrainAwareSampler.latency_of(SMALL.patches) - 1


@as_test(bench_of)
async def test_clear_in_every_cycle_of_a_fetch(ctx, dut, unit):
    for cycles in range(TerrainAwareSampler.latency_of(SMALL.patches)):
        unit.plan()
        ctx.set(dut.fetch, 1)
        for _ in range(cycles):
            await unit.tick()
            ctx.set(dut.fetch, 0)
            ctx.set(dut.settled, not ctx.get(dut.peek))
        ctx.set(dut.clear, 1)
        await unit.tick()
        ctx.set(dut.fetch, 0)
        ctx.set(dut.clear, 0)
        ctx.set(dut.settled, 1)
        for _ in range(TerrainAwareSampler.latency_of(SMALL.patches) + 2):
            assert not ctx.get(dut.fetched)
            assert not ctx.get(dut.peek)
            await unit.tick()
        unit.peeks = 0
        await unit.run(avoid=True)


@as_test(bench_of)
async def test_nothing_outlives_its_generation(ctx, dut, unit):
    """``run`` falls in every cycle; the next generation does not depend on the previous one."""
    for cycles in range(1, SMALL.patches * SMALL.candidates + SMALL.lookup_latency + 6):
        unit.plan()
        ctx.set(dut.avoid, cycles % 2)
        await unit.fetch()
        ctx.set(dut.run, 1)
        for _ in range(cycles):
            await unit.tick()
        ctx.set(dut.run, 0)
        await unit.tick()
        await unit.tick()
        assert not ctx.get(dut.lookup_valid)
        await unit.run(avoid=True)
