# amaranth: UnusedElaboratable=no
"""The exported selection unit against the model."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.ga_core.selection import Selection
from pathgene.hdl.protocol.random_words import WARM_UP_STEPS
from pathgene.sim.model import selection as model
from pathgene.sim.model.random_source import RandomSource


TOP = "selection"
CONFIG = Config(checker=CheckerBuild.NONE)

UNIT = Selection(CONFIG)


class Bench:
    """Driver that sets and samples ports at falling edges."""

    def __init__(self, dut):
        self.dut = dut
        for port in (dut.rst, dut.load, dut.next, dut.seed):
            port.value = 0
        Clock(dut.clk, 10, unit="ns").start()

    async def cycle(self, **inputs):
        """Hold the inputs over one rising edge; return whether a set is ready after it."""
        for name in ("rst", "load", "next", "seed"):
            getattr(self.dut, name).value = inputs.get(name, 0)
        await FallingEdge(self.dut.clk)
        return bool(self.dut.ready.value)

    async def latency(self):
        """Wait for the set after a strobe; return the cycles from the strobe to it."""
        for cycles in range(2, WARM_UP_STEPS + UNIT.latency + 2):
            if await self.cycle():
                return cycles
        raise TimeoutError("no set became ready")

    def draws(self):
        """Return the current set in the model's form."""
        offsets = self._read("offsets")
        return model.Draws(
            *(
                tuple(self._read(name))
                for name in ("parents", "survivors", "children", "waypoints")
            ),
            tuple((offset.x, offset.y, offset.altitude) for offset in offsets),
        )

    def _read(self, name):
        shape = UNIT.signature.members[name].shape
        return shape.from_bits(getattr(self.dut, name).value.to_unsigned())


@cocotb.test()
async def sets_of_several_seeds(dut):
    """Match every set and its latency, through loads and resets; a set stays until ``next``."""
    rng = random.Random(2)
    bench = Bench(dut)
    await FallingEdge(dut.clk)
    unit = model.Selection(CONFIG)
    for seed in (None, 1, rng.getrandbits(64), None, (1 << 64) - 1):
        if seed is None:
            assert not await bench.cycle(rst=1)
            assert await bench.latency() == WARM_UP_STEPS + UNIT.latency
        else:
            assert not await bench.cycle(load=1, seed=seed)
            assert await bench.latency() == WARM_UP_STEPS + UNIT.latency
        source = RandomSource(seed or 0)
        for _ in range(12):
            expected = unit.draw(source)
            assert bench.draws() == expected
            for _ in range(rng.choice((0, 0, 5))):
                assert await bench.cycle()
                assert bench.draws() == expected
            assert not await bench.cycle(next=1)
            assert await bench.latency() == UNIT.latency


@cocotb.test()
async def loads_in_the_middle_of_a_set(dut):
    """Restart after a load in any cycle of a set, without a trace of the set."""
    rng = random.Random(3)
    bench = Bench(dut)
    await bench.cycle(rst=1)
    await bench.latency()
    for cycles in range(UNIT.latency):
        await bench.cycle(next=1)
        for _ in range(cycles):
            # `next` has no effect before the set is ready.
            await bench.cycle(next=cycles < UNIT.latency - 1)
        seed = rng.getrandbits(64)
        assert not await bench.cycle(load=1, seed=seed)
        assert await bench.latency() == WARM_UP_STEPS + UNIT.latency
        assert bench.draws() == model.Selection(CONFIG).draw(RandomSource(seed))
