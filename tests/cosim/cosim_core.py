# amaranth: UnusedElaboratable=no
"""The exported core against the model, in its default configuration."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge, ValueChange
from drivers import Stream

from hdl.config import Config
from hdl.ga_core.core import Core
from hdl.protocol import ChipState, Counter
from sim.model import core as model
from sim.model.mutation import Limits


TOP = "ga_core"
CONFIG = Config()

SIGNATURE = Core(CONFIG).signature


class Bench:
    """Drives the core and the model beside it."""

    def __init__(self, dut, seed, *, stalled=False):
        self.dut = dut
        self.rng = random.Random(seed)
        self.model = model.Core(CONFIG)
        self.streams = {}
        for name in ("starts", "writes", "ranking", "reads", "waypoints"):
            layout = SIGNATURE.members[name].signature.members["payload"].shape
            stream = Stream(dut, name, layout, dut.clk)
            stream.idle(driven=name != "waypoints")
            if stalled:
                stream.pauses = lambda: self.rng.choice((0, 0, 1, 4))
            self.streams[name] = stream
        for name in (
            "pending",
            "receive_over",
            "generate",
            "transmit_over",
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

    def value(self, name, index=None):
        """Return an output, or one of an array of them, in its own shape."""
        port = self.port(name if index is None else f"{name}__{index}").value.to_unsigned()
        shape = SIGNATURE.members[name].shape
        return shape.from_bits(port) if hasattr(shape, "from_bits") else port

    async def start(self, seed):
        limits = Limits(
            self.rng.randrange(CONFIG.map_size),
            self.rng.randrange(CONFIG.map_size),
            self.rng.randrange(CONFIG.blocked_altitude),
        )
        self.model.start(seed, limits)
        await self.streams["starts"].put(
            {"seed": seed, "x": limits.x, "y": limits.y, "altitude": limits.altitude}
        )

    async def load(self, slot, length=None):
        length = length or self.rng.randint(CONFIG.MIN_WAYPOINTS, CONFIG.max_waypoints)
        path = [self.rng.getrandbits(CONFIG.waypoint_bits) for _ in range(length)]
        self.model.paths[slot] = path
        await self.streams["writes"].put(
            *(
                {"slot": slot, "index": index, "waypoint": waypoint, "last": index == length - 1}
                for index, waypoint in enumerate(path)
            )
        )

    async def load_all(self, length=None):
        for slot in range(CONFIG.population):
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
        await self.check_paths(0, CONFIG.population)

    async def enter(self, state):
        while self.dut.state.value.to_unsigned() != state:
            await ValueChange(self.dut.state)
        await FallingEdge(self.dut.clk)

    async def generate(self):
        """Run a generation on a random order, and check all that it says it did."""
        order = self.rng.sample(range(CONFIG.population), CONFIG.population)
        self.port("pending").value = 1
        await self.enter(ChipState.RECEIVE)
        self.port("pending").value = 0
        await self.streams["ranking"].put(
            *({"rank": rank, "slot": slot} for rank, slot in enumerate(order))
        )
        self.port("generate").value = 1
        self.port("receive_over").value = 1
        await self.enter(ChipState.CROSSOVER)
        self.port("generate").value = 0
        self.port("receive_over").value = 0
        await self.enter(ChipState.TRANSMIT)
        self.port("transmit_over").value = 1
        await self.enter(ChipState.LISTEN)
        self.port("transmit_over").value = 0

        done = self.model.run(order)
        slots = tuple(self.value("parents", i) for i in range(CONFIG.crossovers))
        assert slots == done.parents
        slots = tuple(self.value("survivors", i) for i in range(CONFIG.survivors))
        assert slots == done.survivors
        for i, mutated in enumerate(done.mutations):
            mutation = self.value("mutations", i)
            assert (mutation.applied, mutation.child, mutation.index) == (
                mutated.applied,
                mutated.child,
                mutated.index,
            )
            if i < CONFIG.patches:
                assert self.value("patches", i) == mutated.waypoint
        clocks = self.value("clocks")
        assert (clocks.crossover, clocks.mutation, clocks.update) == (
            done.crossover_clocks,
            done.mutation_clocks,
            done.update_clocks,
        )
        assert self.value("generation") == self.model.generation
        return done


@cocotb.test()
@cocotb.parametrize(stalled=[False, True])
async def random_generations(dut, stalled):
    """Random paths; loads, reads and new seeds between the generations."""
    bench = Bench(dut, seed=1, stalled=stalled)
    await bench.reset()
    if not stalled:
        # The memories keep what they hold over a reset; here they have been written never.
        await bench.check_population()
    await bench.load_all()
    await bench.check_population()
    for generation in range(20):
        if generation % 7 == 3:
            await bench.start(bench.rng.getrandbits(64))
        await bench.generate()
        if generation % 5 == 4:
            await bench.check_population()
        slot = bench.rng.randrange(CONFIG.population)
        await bench.check_paths(slot, min(2, CONFIG.population - slot))
        await bench.load(bench.rng.randrange(CONFIG.population))
    await bench.check_population()


@cocotb.test()
async def full_length_parents(dut):
    """At most ``max_waypoints + 8`` clocks a generation; in fact 4 more than waypoints."""
    bench = Bench(dut, seed=2)
    await bench.reset()
    refused = 0
    for _ in range(3):
        await bench.load_all(CONFIG.max_waypoints)
        for _ in range(10):
            done = await bench.generate()
            refused += sum(not mutated.applied for mutated in done.mutations)
            longest = bench.value("counters")[Counter.LONGEST]
            assert longest == CONFIG.max_waypoints + 4 <= CONFIG.max_waypoints + 8
        await bench.check_population()
    counters = bench.value("counters")
    assert refused > 0
    assert counters[Counter.REFUSED_MUTATIONS] == refused
    assert counters[Counter.GENERATIONS] == 30


@cocotb.test()
async def generation_waits_for_its_draws(dut):
    """A generation asked for at once after a new seed starts when its draws are there."""
    bench = Bench(dut, seed=3)
    await bench.reset()
    await bench.load_all()
    for _ in range(4):
        await bench.start(bench.rng.getrandbits(64))
        await bench.generate()
        await bench.generate()
    await bench.check_population()


@cocotb.test()
async def ranked_after_the_last_rank(dut):
    """``ranked`` rises as many clocks after the last rank as the docstring says."""
    bench = Bench(dut, seed=4)
    await bench.reset()
    await bench.streams["ranking"].put(
        *({"rank": rank, "slot": rank} for rank in range(CONFIG.population))
    )
    begun = cocotb.simtime.get_sim_time("ns")
    await RisingEdge(dut.ranked)
    elapsed = cocotb.simtime.get_sim_time("ns") - begun
    # From the falling edge after the last rank's clock to a rising edge.
    assert elapsed == 10 * (CONFIG.mutators + 9) - 15
