# amaranth: UnusedElaboratable=no
"""The exported selection unit against the model."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from hdl.config import CheckerBuild, Config
from hdl.ga_core.selection import Selection
from hdl.protocol.random_words import WARM_UP_STEPS
from sim.model import selection as model
from sim.model.random_source import RandomSource


TOP = "selection"
CONFIG = Config(checker=CheckerBuild.NONE)

UNIT = Selection(CONFIG)


class Bench:
    """Drives and samples at falling edges, in the middle of a clock."""

    def __init__(self, dut):
        self.dut = dut
        for port in (dut.rst, dut.load, dut.next, dut.seed):
            port.value = 0
        Clock(dut.clk, 10, unit="ns").start()

    async def clock(self, **inputs):
        """Hold the inputs over one rising edge; return whether a set is ready after it."""
        for name in ("rst", "load", "next", "seed"):
            getattr(self.dut, name).value = inputs.get(name, 0)
        await FallingEdge(self.dut.clk)
        return bool(self.dut.ready.value)

    async def latency(self):
        """Wait for the set after a strobe; return the clocks from the strobe to it."""
        for clocks in range(2, WARM_UP_STEPS + UNIT.latency + 2):
            if await self.clock():
                return clocks
        raise TimeoutError("no set became ready")

    def draws(self):
        """Return the present set as the model's draws."""
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
    """Sets, when they come, and that they stay, through loads and a reset."""
    rng = random.Random(2)
    bench = Bench(dut)
    await FallingEdge(dut.clk)
    unit = model.Selection(CONFIG)
    for seed in (None, 1, rng.getrandbits(64), None, (1 << 64) - 1):
        if seed is None:
            assert not await bench.clock(rst=1)
            assert await bench.latency() == WARM_UP_STEPS + UNIT.latency
        else:
            assert not await bench.clock(load=1, seed=seed)
            assert await bench.latency() == WARM_UP_STEPS + UNIT.latency
        source = RandomSource(seed or 0)
        for _ in range(12):
            expected = unit.draw(source)
            assert bench.draws() == expected
            for _ in range(rng.choice((0, 0, 5))):
                assert await bench.clock()
                assert bench.draws() == expected
            assert not await bench.clock(next=1)
            assert await bench.latency() == UNIT.latency


@cocotb.test()
async def loads_in_the_middle_of_a_set(dut):
    """A load in any clock of a set begins anew, and leaves nothing of the set behind."""
    rng = random.Random(3)
    bench = Bench(dut)
    await bench.clock(rst=1)
    await bench.latency()
    for clocks in range(UNIT.latency):
        await bench.clock(next=1)
        for _ in range(clocks):
            # `next` before the set is ready does nothing.
            await bench.clock(next=clocks < UNIT.latency - 1)
        seed = rng.getrandbits(64)
        assert not await bench.clock(load=1, seed=seed)
        assert await bench.latency() == WARM_UP_STEPS + UNIT.latency
        assert bench.draws() == model.Selection(CONFIG).draw(RandomSource(seed))
