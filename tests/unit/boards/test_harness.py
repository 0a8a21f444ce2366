"""The registers around a unit reach every input and observe every output."""

import itertools

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.boards.harness import Harness
from tests.support.gateware.streams import simulate


class Unit(wiring.Component):
    """Unit that copies five input bits to its outputs."""

    word: In(data.StructLayout({"low": 2, "high": 1}))
    flags: In(1).array(2)
    copy: Out(3)
    copied: Out(1).array(2)

    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.copy.eq(self.word)
        for target, source in zip(self.copied, self.flags, strict=True):
            m.d.comb += target.eq(source)
        return m


def responses(bits):
    """Return ``folded`` in each cycle while ``bits`` are scanned in."""
    dut = Harness(Unit())
    seen = []

    async def bench(ctx):
        for bit in bits:
            ctx.set(dut.scanned_in, bit)
            seen.append(ctx.get(dut.folded))
            await ctx.tick()

    simulate(dut, bench)
    return seen


def test_every_input_and_output():
    """A single bit passes all five inputs, and each output shows it once."""
    seen = responses([1] + [0] * 30)
    # In cycle 2 + i the bit is in the register of input i. From there it goes through the sampling
    # register and one register for each output from i to the end.
    arrivals = [2 + i + 1 + (5 - i) for i in range(5)]
    assert len(set(arrivals)) == 1
    odd = [cycle for cycle, bit in enumerate(seen) if bit]
    assert odd == [arrivals[0]]
    assert len(arrivals) % 2 == 1  # An even number would cancel out.


def test_responses_are_linear():
    """The response to two bits is the sum of the responses to each."""
    for first, second in itertools.combinations(range(4), 2):
        one, two = ([int(cycle == at) for cycle in range(30)] for at in (first, second))
        both = [a ^ b for a, b in zip(one, two, strict=True)]
        folded = [a ^ b for a, b in zip(responses(one), responses(two), strict=True)]
        assert responses(both) == folded
