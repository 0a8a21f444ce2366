# amaranth: UnusedElaboratable=no
"""The whole core against the model: populations, slots, mutations and clocks."""

import itertools
import random

import pytest
from amaranth.hdl import Value
from amaranth.sim import Simulator

from hdl.config import Config, SurvivorSelection
from hdl.ga_core.core import Core
from hdl.protocol import ChipState, Counter
from sim.model import core as model
from sim.model.mutation import Limits


SMALL = Config(
    population=8,
    children=4,
    elites=2,
    survivors=2,
    perturbs=1,
    inserts=1,
    deletes=1,
    max_waypoints=4,
    map_size=16,
    coarse_factor=4,
    altitude_bits=4,
)
CONFIGS = {
    "small": SMALL,
    "shortest": SMALL.replace(max_waypoints=3),
    "odd": SMALL.replace(max_waypoints=5, survivors=1, elites=1, children=6, deletes=3, inserts=2),
    "longest": SMALL.replace(max_waypoints=20, perturbs=2),
    "by_rank": SMALL.replace(
        elites=1, survivors=3, box_percent=100, survivor_selection=SurvivorSelection.RANK
    ),
}
#: The paper's population; the map and the paths are small.
FULL = Config(max_waypoints=6, map_size=32, coarse_factor=4, altitude_bits=4)


class Driver:
    """Drives a core, and the model beside it, in one test bench.

    Parameters
    ----------
    ctx : amaranth.sim.SimulatorContext
    dut : Core
    rng : random.Random
    pauses : iterable of int
        Clocks before each word of a stream, for ever.
    """

    LIMIT = 400

    def __init__(self, ctx, dut, rng, pauses=(0,)):
        self.ctx, self.dut, self.rng = ctx, dut, rng
        self.config = dut.config
        self.model = model.Core(dut.config)
        self.pauses = itertools.cycle(pauses)
        self.clocks = 0

    async def tick(self):
        self.clocks += 1
        await self.ctx.tick()

    async def put(self, stream, payload):
        for _ in range(next(self.pauses)):
            await self.tick()
        self.ctx.set(stream.valid, 1)
        self.ctx.set(stream.payload, payload)
        for _ in range(self.LIMIT):
            ready = self.ctx.get(stream.ready)
            await self.tick()
            if ready:
                break
        else:
            raise TimeoutError(f"No transfer of {payload!r}")
        self.ctx.set(stream.valid, 0)

    async def start(self, seed):
        config = self.config
        limits = Limits(
            self.rng.randrange(config.map_size),
            self.rng.randrange(config.map_size),
            self.rng.randrange(config.blocked_altitude),
        )
        self.model.start(seed, limits)
        await self.put(
            self.dut.starts,
            {"seed": seed, "x": limits.x, "y": limits.y, "altitude": limits.altitude},
        )

    def path(self, length=None):
        config = self.config
        length = length or self.rng.randint(config.MIN_WAYPOINTS, config.max_waypoints)
        return [self.rng.getrandbits(config.waypoint_bits) for _ in range(length)]

    async def load(self, slot, path):
        self.model.paths[slot] = path
        for index, waypoint in enumerate(path):
            await self.put(
                self.dut.writes,
                {
                    "slot": slot,
                    "index": index,
                    "waypoint": waypoint,
                    "last": index == len(path) - 1,
                },
            )

    async def read(self, slot, count):
        await self.put(self.dut.reads, {"slot": slot, "count": count})
        ctx, waypoints = self.ctx, self.dut.waypoints
        paths = [[]]
        for _ in range(self.LIMIT * count):
            pause = next(self.pauses)
            for _ in range(pause):
                await self.tick()
            ctx.set(waypoints.ready, 1)
            while not ctx.get(waypoints.valid):
                await self.tick()
            word = ctx.get(waypoints.payload)
            await self.tick()
            ctx.set(waypoints.ready, 0)
            paths[-1].append(word.waypoint)
            if word.final:
                assert word.last
                return paths
            if word.last:
                paths.append([])
        raise TimeoutError("No end of a read")

    async def check_population(self):
        assert await self.read(0, self.config.population) == self.model.paths

    async def rank(self, order):
        for rank, slot in enumerate(order):
            await self.put(self.dut.ranking, {"rank": rank, "slot": slot})

    async def enter(self, state):
        for _ in range(self.LIMIT):
            if self.ctx.get(self.dut.state) == state:
                return
            await self.tick()
        raise TimeoutError(f"Never in {state!r}")

    async def generate(self, order):
        """Run a generation, and check all that it says it did."""
        ctx, dut = self.ctx, self.dut
        ctx.set(dut.pending, 1)
        await self.enter(ChipState.RECEIVE)
        ctx.set(dut.pending, 0)
        await self.rank(order)
        ctx.set(dut.receive_over, 1)
        ctx.set(dut.generate, 1)
        await self.enter(ChipState.CROSSOVER)
        ctx.set(dut.receive_over, 0)
        ctx.set(dut.generate, 0)
        started = self.clocks
        await self.enter(ChipState.TRANSMIT)
        elapsed = self.clocks - started
        ctx.set(dut.transmit_over, 1)
        await self.enter(ChipState.LISTEN)
        ctx.set(dut.transmit_over, 0)

        expected = self.model.run(order)
        assert tuple(ctx.get(slot) for slot in dut.parents) == expected.parents
        assert tuple(ctx.get(slot) for slot in dut.survivors) == expected.survivors
        for mutation, mutated in zip(dut.mutations, expected.mutations, strict=True):
            done = ctx.get(mutation)
            assert (done.applied, done.child, done.index) == (
                mutated.applied,
                mutated.child,
                mutated.index,
            )
        for patch, mutated in zip(dut.patches, expected.mutations, strict=False):
            assert ctx.get(patch) == mutated.waypoint
        clocks = ctx.get(dut.clocks)
        assert (clocks.crossover, clocks.mutation, clocks.update) == (
            expected.crossover_clocks,
            expected.mutation_clocks,
            expected.update_clocks,
        )
        assert elapsed == sum((clocks.crossover, clocks.mutation, clocks.update))
        assert elapsed <= self.config.max_waypoints + 4
        assert ctx.get(dut.generation) == self.model.generation
        return expected


def simulate(config, bench):
    dut = Core(config)
    simulator = Simulator(dut)
    simulator.add_clock(1e-8)

    async def testbench(ctx):
        await bench(ctx, dut)

    simulator.add_testbench(testbench)
    simulator.run()


def shuffled(rng, config):
    return rng.sample(range(config.population), config.population)


async def fill(driver, length=None):
    """Load a random path into every slot."""
    for slot in range(driver.config.population):
        await driver.load(slot, driver.path(length))


@pytest.mark.parametrize("name", CONFIGS)
def test_matches_model(name):
    """Random paths, then generations with reads, loads and new seeds in between."""
    config = CONFIGS[name]
    pauses = (0, 2, 0, 1) if name in ("odd", "by_rank") else (0,)

    async def bench(ctx, dut):
        rng = random.Random(name)
        driver = Driver(ctx, dut, rng, pauses)
        await driver.check_population()
        await fill(driver)
        for generation in range(12):
            await driver.generate(shuffled(rng, config))
            if generation % 4 == 0:
                await driver.check_population()
            if generation % 4 == 1:
                slot = rng.randrange(config.population)
                await driver.load(slot, driver.path())
            if generation % 4 == 2:
                slot = rng.randrange(config.population)
                count = rng.randint(1, config.population - slot)
                assert await driver.read(slot, count) == driver.model.paths[slot : slot + count]
            if generation % 6 == 5:
                await driver.start(rng.getrandbits(64))
        await driver.check_population()

    simulate(config, bench)


def test_population_of_the_paper():
    async def bench(ctx, dut):
        rng = random.Random(1)
        driver = Driver(ctx, dut, rng)
        await fill(driver)
        for _ in range(2):
            await driver.generate(shuffled(rng, FULL))
        await driver.check_population()

    simulate(FULL, bench)


def test_longest_paths_take_four_clocks_more_than_waypoints():
    async def bench(ctx, dut):
        rng = random.Random(2)
        driver = Driver(ctx, dut, rng)
        await driver.start(1)
        await fill(driver, SMALL.max_waypoints)
        for _ in range(3):
            await driver.generate(shuffled(rng, SMALL))
            counters = ctx.get(dut.counters)
            assert counters[Counter.LONGEST] == SMALL.max_waypoints + 4

    simulate(SMALL, bench)


def test_refused_mutations_are_counted():
    async def bench(ctx, dut):
        rng = random.Random(3)
        driver = Driver(ctx, dut, rng)
        refused = 0
        for _ in range(6):
            done = await driver.generate(shuffled(rng, SMALL))
            refused += sum(not mutated.applied for mutated in done.mutations)
        # All paths have two waypoints at first, so that deletions are refused.
        assert refused > 1
        assert ctx.get(dut.counters)[Counter.REFUSED_MUTATIONS] == refused

    simulate(SMALL, bench)


async def ranked_after(driver):
    """Return the clocks from the last word of a ranking to ``ranked``."""
    clocks = 1
    while not driver.ctx.get(driver.dut.ranked):
        await driver.tick()
        clocks += 1
        assert clocks < 50
    return clocks


def test_clocks_of_a_ranking():
    async def bench(ctx, dut):
        driver = Driver(ctx, dut, random.Random(4))
        await driver.rank(range(SMALL.population))
        assert await ranked_after(driver) == SMALL.mutators + 9

    simulate(SMALL, bench)


@pytest.mark.parametrize("event", ["start", "write", "rank", "generation"])
def test_ranking_becomes_void(event):
    async def bench(ctx, dut):
        rng = random.Random(5)
        driver = Driver(ctx, dut, rng)
        order = shuffled(rng, SMALL)
        for wait in range(SMALL.mutators + 12):
            await driver.rank(order)
            # The event comes while the ranking is being worked in, or later.
            for _ in range(wait):
                await driver.tick()
            match event:
                case "start":
                    await driver.start(wait)
                case "write":
                    await driver.load(1, driver.path())
                case "rank":
                    await driver.rank([3])
                case "generation":
                    await driver.generate(order)
            for _ in range(SMALL.mutators + 12):
                assert not ctx.get(dut.ranked)
                await driver.tick()
        await driver.generate(order)
        await driver.check_population()

    simulate(SMALL, bench)


def test_results_stay_until_the_next_generation():
    async def bench(ctx, dut):
        rng = random.Random(6)
        driver = Driver(ctx, dut, rng)

        def results():
            ports = (*dut.parents, *dut.survivors, *dut.mutations, *dut.patches)
            return [ctx.get(Value.cast(port)) for port in ports]

        await fill(driver)
        await driver.generate(shuffled(rng, SMALL))
        before = results()
        await driver.rank(shuffled(rng, SMALL))
        await ranked_after(driver)
        assert results() == before
        await driver.generate(shuffled(rng, SMALL))
        assert results() != before

    simulate(SMALL, bench)


def test_nothing_is_taken_during_a_generation():
    async def bench(ctx, dut):
        driver = Driver(ctx, dut, random.Random(7))
        await driver.rank(range(SMALL.population))
        await ranked_after(driver)
        for name in ("pending", "receive_over", "generate"):
            ctx.set(getattr(dut, name), 1)
        await driver.enter(ChipState.CROSSOVER)
        for flow in (dut.starts, dut.writes, dut.ranking, dut.reads):
            ctx.set(flow.valid, 1)
        while ctx.get(dut.state) != ChipState.TRANSMIT:
            for flow in (dut.starts, dut.writes, dut.ranking, dut.reads):
                assert not ctx.get(flow.ready)
            await driver.tick()
        assert ctx.get(dut.starts.ready)

    simulate(SMALL, bench)


def test_wrong_config():
    with pytest.raises(TypeError, match=r"^Config must be a Config, not 32$"):
        Core(32)
