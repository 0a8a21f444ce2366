"""Driver of the paper core and its model in the Amaranth simulator."""

import collections
import functools
import itertools
import random

from pathgene.hdl.config import CheckerBuild
from pathgene.hdl.ga_core_top import PaperCoreTop
from pathgene.hdl.protocol.codes import ChipState
from pathgene.sim.model import core as model
from pathgene.sim.model.checker import TerrainModel
from pathgene.sim.model.mutation import Limits
from tests.support.gateware import streams
from tests.support.gateware.streams import shared


class Driver:
    """Driver of a core and its model.

    On a chip with a map, the driver answers lookups; at other times the altitude is random.

    Parameters
    ----------
    pauses : iterable of int
        Idle cycles before each word of a stream, repeated.

    Attributes
    ----------
    lookups : list of (int, int)
        Cells that the latest generation looked up.
    """

    LIMIT = 400

    def __init__(self, ctx, dut, rng, pauses=(0,)):
        self.ctx, self.dut, self.rng = ctx, dut, rng
        self.config = dut.config
        self.has_map = dut.config.checker is not CheckerBuild.NONE
        self.terrain = TerrainModel(dut.config) if self.has_map else None
        self.model = model.PaperCore(dut.config, self.terrain)
        self.lookups = []
        self.looked_up = collections.deque([None] * (dut.config.lookup_latency - 1))
        self.garbage = random.Random(0)
        self.pauses = itertools.cycle(pauses)
        self.cycles = 0

    async def tick(self):
        self.cycles += 1
        if self.has_map:
            self.look_up()
            await self.ctx.tick()
            cell = self.looked_up.popleft()
            altitude = self.garbage.getrandbits(self.config.altitude_bits)
            if cell is not None:
                altitude = int(self.terrain.heights[cell[1], cell[0]])
            self.ctx.set(self.dut.lookup_altitude, altitude)
        else:
            await self.ctx.tick()

    def look_up(self):
        ctx, dut = self.ctx, self.dut
        cell = None
        if ctx.get(dut.lookup_valid):
            assert ctx.get(dut.state) in (ChipState.CROSSOVER, ChipState.MUTATE, ChipState.UPDATE)
            cell = ctx.get(dut.lookup_x), ctx.get(dut.lookup_y)
            self.lookups.append(cell)
        self.looked_up.append(cell)

    def survey(self, lowest=0, highest=None):
        """Set every cell of the map to a random altitude."""
        size = self.config.map_size
        highest = self.config.blocked_altitude if highest is None else highest
        self.terrain.write(
            0, 0, [[self.rng.randint(lowest, highest) for _ in range(size)] for _ in range(size)]
        )

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

    async def start(self, seed, *, limits=None, avoid_ground=False):
        """Start a run; limits default to random ones."""
        config = self.config
        limits = limits or Limits(
            self.rng.randrange(config.map_size),
            self.rng.randrange(config.map_size),
            self.rng.randrange(config.blocked_altitude),
        )
        self.model.start(seed, limits, avoid_ground)
        await self.put(
            self.dut.start_requests,
            {
                "seed": seed,
                "x": limits.x,
                "y": limits.y,
                "altitude": limits.altitude,
                "avoid_ground": avoid_ground,
            },
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
        """Run a generation and compare everything the core reports with the model."""
        ctx, dut = self.ctx, self.dut
        self.lookups.clear()
        ctx.set(dut.pending, 1)
        await self.enter(ChipState.RECEIVE)
        ctx.set(dut.pending, 0)
        await self.rank(order)
        ctx.set(dut.receive_done, 1)
        ctx.set(dut.generate, 1)
        await self.enter(ChipState.CROSSOVER)
        ctx.set(dut.receive_done, 0)
        ctx.set(dut.generate, 0)
        started = self.cycles
        await self.enter(ChipState.TRANSMIT)
        elapsed = self.cycles - started
        ctx.set(dut.transmit_done, 1)
        await self.enter(ChipState.LISTEN)
        ctx.set(dut.transmit_done, 0)

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
        cycles = ctx.get(dut.cycles)
        assert (cycles.crossover, cycles.mutation, cycles.update) == (
            expected.crossover_cycles,
            expected.mutation_cycles,
            expected.update_cycles,
        )
        assert elapsed == sum((cycles.crossover, cycles.mutation, cycles.update))
        if not self.has_map:
            assert elapsed <= self.config.max_waypoints + 4
        assert ctx.get(dut.generation) == self.model.generation
        return expected


def simulate(config, bench):
    dut = shared(PaperCoreTop, config)
    streams.simulate(dut, functools.partial(bench, dut=dut))


def shuffled(rng, config):
    return rng.sample(range(config.population), config.population)


async def fill(driver, length=None):
    """Load a random path into every slot."""
    for slot in range(driver.config.population):
        await driver.load(slot, driver.path(length))


async def ranked_after(driver):
    """Return the cycles from the last word of a ranking to ``ranked``."""
    cycles = 1
    while not driver.ctx.get(driver.dut.ranked):
        await driver.tick()
        cycles += 1
        assert cycles < 50
    return cycles
