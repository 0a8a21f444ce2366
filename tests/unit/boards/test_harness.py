# amaranth: UnusedElaboratable=no
"""The registers around a unit: every input is reached, every output is seen."""

import itertools

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from hdl.boards.harness import Harness
from tests.streams import simulate


class Unit(wiring.Component):
    """Has inputs of five bits, and as many outputs that are the same."""

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
    """Return ``folded`` in each clock when ``bits`` are scanned in one after another."""
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
    """A single bit passes all five inputs; each output that it leaves by shows it once."""
    seen = responses([1] + [0] * 30)
    # In clock 2 + i it is in the register of input i; from the output of that input it takes the
    # sampling register, and one for each output from there to the end.
    arrivals = [2 + i + 1 + (5 - i) for i in range(5)]
    assert len(set(arrivals)) == 1
    odd = [clock for clock, bit in enumerate(seen) if bit]
    assert odd == [arrivals[0]]
    assert len(arrivals) % 2 == 1  # Else they would cancel out.


def test_it_is_linear():
    """Responses to two bits are the sum of the responses to each."""
    for first, second in itertools.combinations(range(4), 2):
        one, two = ([int(clock == at) for clock in range(30)] for at in (first, second))
        both = [a ^ b for a, b in zip(one, two, strict=True)]
        folded = [a ^ b for a, b in zip(responses(one), responses(two), strict=True)]
        assert responses(both) == folded
