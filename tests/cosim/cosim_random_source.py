"""The exported random source against the model."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from hdl.protocol.random_words import LANES, WARM_UP_STEPS, WORD_BITS
from sim.model.random_source import RandomSource


TOP = "random_source"


class Bench:
    """Drives and samples at falling edges, in the middle of a clock."""

    def __init__(self, dut):
        self.dut = dut
        for port in (dut.rst, dut.load, dut.step, dut.seed):
            port.value = 0
        Clock(dut.clk, 10, unit="ns").start()

    async def clock(self, **inputs):
        """Hold the inputs for one clock; return what the outputs were in it, or None."""
        for name in ("rst", "load", "step", "seed"):
            getattr(self.dut, name).value = inputs.get(name, 0)
        await FallingEdge(self.dut.clk)
        words = None
        if self.dut.ready.value:
            packed = self.dut.words.value.to_unsigned().to_bytes(LANES * WORD_BITS // 8, "little")
            lanes = range(0, len(packed), WORD_BITS // 8)
            words = tuple(int.from_bytes(packed[i : i + WORD_BITS // 8], "little") for i in lanes)
        return words

    async def warm_up(self, first=False):
        """Check that the clocks after a load are the warm-up's, to the last but one.

        At the ``first`` one, two of them have passed.
        """
        for _ in range(WARM_UP_STEPS - (2 if first else 1)):
            assert await self.clock() is None


@cocotb.test()
async def words_of_several_seeds(dut):
    """Each clock's words, stepped at random, from power-up and through loads."""
    rng = random.Random(1)
    bench = Bench(dut)
    await FallingEdge(dut.clk)
    for seed in (None, 0, 1, (1 << 64) - 1, rng.getrandbits(64), rng.getrandbits(64)):
        # The load takes this clock; its end shows the state loaded.
        if seed is not None:
            assert await bench.clock(load=1, seed=seed, step=rng.randrange(2)) is None
        await bench.warm_up(first=seed is None)

        source = RandomSource(seed or 0)
        expected = source.step()
        assert await bench.clock(step=1) == expected, "ready late, or a step was not ignored"
        for _ in range(200):
            step = rng.randrange(2)
            if step:
                expected = source.step()
            # A reset does nothing.
            assert await bench.clock(step=step, rst=rng.randrange(2)) == expected
