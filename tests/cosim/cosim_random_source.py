"""The exported random source against the model."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from pathgene.hdl.protocol.random_words import LANES, WARM_UP_STEPS, WORD_BITS
from pathgene.sim.model.random_source import RandomSource


TOP = "random_source"


class Bench:
    """Driver that sets and samples ports at falling edges."""

    def __init__(self, dut):
        self.dut = dut
        for port in (dut.rst, dut.load, dut.step, dut.seed):
            port.value = 0
        Clock(dut.clk, 10, unit="ns").start()

    async def cycle(self, **inputs):
        """Hold the inputs for one cycle; return its words, or None if they are not ready."""
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
        """Pass all cycles of the warm-up except the last, and check that no words are ready.

        After power-up (``first``) one cycle more has passed already.
        """
        for _ in range(WARM_UP_STEPS - (2 if first else 1)):
            assert await self.cycle() is None


@cocotb.test()
async def words_of_several_seeds(dut):
    """Match the words of every cycle, with random steps, from power-up and through loads."""
    rng = random.Random(1)
    bench = Bench(dut)
    await FallingEdge(dut.clk)
    for seed in (None, 0, 1, (1 << 64) - 1, rng.getrandbits(64), rng.getrandbits(64)):
        # The load takes one cycle.
        if seed is not None:
            assert await bench.cycle(load=1, seed=seed, step=rng.randrange(2)) is None
        await bench.warm_up(first=seed is None)

        source = RandomSource(seed or 0)
        expected = source.step()
        assert await bench.cycle(step=1) == expected, "ready late, or a step was not ignored"
        for _ in range(200):
            step = rng.randrange(2)
            if step:
                expected = source.step()
            # A reset has no effect.
            assert await bench.cycle(step=step, rst=rng.randrange(2)) == expected
