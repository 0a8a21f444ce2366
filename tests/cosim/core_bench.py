"""Driver of the paper core and its model for cocotb benches."""

import collections
import random

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge, ValueChange
from drivers import Stream

from pathgene.hdl.config import CheckerBuild
from pathgene.hdl.ga_core_top import PaperCoreTop
from pathgene.hdl.protocol import ChipState
from pathgene.sim.model import core as model
from pathgene.sim.model.checker import TerrainModel
from pathgene.sim.model.mutation import Limits


class Bench:
    """Driver of the core and its model; answers lookups on a chip with a map.

    Parameters
    ----------
    dut : cocotb handle
    config : Config
    seed : int
        Seed of all draws.
    stalled : bool
        Whether the streams pause.
    """

    def __init__(self, dut, config, seed, *, stalled=False):
        self.dut = dut
        self.config = config
        self.signature = PaperCoreTop(config).signature
        self.rng = random.Random(seed)
        self.has_map = config.checker is not CheckerBuild.NONE
        self.terrain = TerrainModel(config) if self.has_map else None
        self.model = model.PaperCore(config, self.terrain)
        self.streams = {}
        for name in ("start_requests", "writes", "ranking", "reads", "waypoints"):
            layout = self.signature.members[name].signature.members["payload"].shape
            stream = Stream(dut, name, layout, dut.clk)
            stream.idle(driven=name != "waypoints")
            if stalled:
                stream.pauses = lambda: self.rng.choice((0, 0, 1, 4))
            self.streams[name] = stream
        for name in (
            "pending",
            "receive_done",
            "generate",
            *(("check", "check_done") if self.has_map else ()),
            "transmit_done",
            "line_busy",
            "line_sending",
        ):
            self.port(name).value = 0

    def port(self, name):
        return self.dut[name]

    async def reset(self):
        self.dut.rst.value = 1
        Clock(self.dut.clk, 10, unit="ns").start()
        await FallingEdge(self.dut.clk)
        await FallingEdge(self.dut.clk)
        self.dut.rst.value = 0
        if self.has_map:
            cocotb.start_soon(self.answer_lookups())

    async def answer_lookups(self):
        """Drive the altitude of each cell after its latency, and random values at other times."""
        dut, bits = self.dut, self.config.altitude_bits
        cells = collections.deque([None] * self.config.lookup_latency)
        garbage = random.Random(0)
        while True:
            if not any(cells):
                await RisingEdge(dut.lookup_valid)
                await FallingEdge(dut.clk)
            valid = dut.lookup_valid.value
            x, y = (port.value.to_unsigned() for port in (dut.lookup_x, dut.lookup_y))
            cells.append((x, y) if valid else None)
            cell = cells.popleft()
            altitude = garbage.getrandbits(bits)
            if cell is not None:
                altitude = int(self.terrain.heights[cell[1], cell[0]])
            dut.lookup_altitude.value = altitude
            await FallingEdge(dut.clk)

    def survey(self, lowest, highest):
        """Set every cell of the map to a random altitude."""
        size = self.config.map_size
        generator = np.random.default_rng(self.rng.getrandbits(32))
        self.terrain.write(0, 0, generator.integers(lowest, highest + 1, (size, size)))

    def value(self, name, index=None):
        """Return an output, or an element of an array of outputs, in its shape."""
        port = self.port(name if index is None else f"{name}__{index}").value.to_unsigned()
        shape = self.signature.members[name].shape
        return shape.from_bits(port) if hasattr(shape, "from_bits") else port

    async def start(self, seed, *, avoid_ground=False):
        limits = Limits(
            self.rng.randrange(self.config.map_size),
            self.rng.randrange(self.config.map_size),
            self.rng.randrange(self.config.blocked_altitude),
        )
        self.model.start(seed, limits, avoid_ground)
        await self.streams["start_requests"].put(
            {
                "seed": seed,
                "x": limits.x,
                "y": limits.y,
                "altitude": limits.altitude,
                "avoid_ground": avoid_ground,
            }
        )

    async def load(self, slot, length=None):
        length = length or self.rng.randint(self.config.MIN_WAYPOINTS, self.config.max_waypoints)
        path = [self.rng.getrandbits(self.config.waypoint_bits) for _ in range(length)]
        self.model.paths[slot] = path
        await self.streams["writes"].put(
            *(
                {"slot": slot, "index": index, "waypoint": waypoint, "last": index == length - 1}
                for index, waypoint in enumerate(path)
            )
        )

    async def load_all(self, length=None):
        for slot in range(self.config.population):
            await self.load(slot, length)

    async def check_paths(self, slot, count):
        await self.streams["reads"].put({"slot": slot, "count": count})
        paths = [[]]
        for word in await self.streams["waypoints"].get_until("final"):
            paths[-1].append(word.waypoint)
            if word.last:
                paths.append([])
        assert paths.pop() == []
        assert paths == self.model.paths[slot : slot + count]

    async def check_population(self):
        await self.check_paths(0, self.config.population)

    async def enter(self, state):
        while self.dut.state.value.to_unsigned() != state:
            await ValueChange(self.dut.state)
        await FallingEdge(self.dut.clk)

    async def generate(self):
        """Run a generation with a random ranking and compare the core's reports with the model."""
        order = self.rng.sample(range(self.config.population), self.config.population)
        self.port("pending").value = 1
        await self.enter(ChipState.RECEIVE)
        self.port("pending").value = 0
        await self.streams["ranking"].put(
            *({"rank": rank, "slot": slot} for rank, slot in enumerate(order))
        )
        self.port("generate").value = 1
        self.port("receive_done").value = 1
        await self.enter(ChipState.CROSSOVER)
        self.port("generate").value = 0
        self.port("receive_done").value = 0
        await self.enter(ChipState.TRANSMIT)
        self.port("transmit_done").value = 1
        await self.enter(ChipState.LISTEN)
        self.port("transmit_done").value = 0

        done = self.model.run(order)
        slots = tuple(self.value("parents", i) for i in range(self.config.crossovers))
        assert slots == done.parents
        slots = tuple(self.value("survivors", i) for i in range(self.config.survivors))
        assert slots == done.survivors
        for i, mutated in enumerate(done.mutations):
            mutation = self.value("mutations", i)
            assert (mutation.applied, mutation.child, mutation.index) == (
                mutated.applied,
                mutated.child,
                mutated.index,
            )
            if i < self.config.patches:
                assert self.value("patches", i) == mutated.waypoint
        cycles = self.value("cycles")
        assert (cycles.crossover, cycles.mutation, cycles.update) == (
            done.crossover_cycles,
            done.mutation_cycles,
            done.update_cycles,
        )
        assert self.value("generation") == self.model.generation
        return done
