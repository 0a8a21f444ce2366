"""Multiplier of the ECP5 with its output register, which synthesis leaves unused."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Given, Unit


__all__ = ["FACTOR_BITS", "Ecp5Multiplier"]

#: Maximum bits of a factor, including its sign if it is signed.
FACTOR_BITS = 18


class Ecp5Multiplier(Unit):
    """One MULT18X18D with a register at its output.

    Twin of :class:`pathgene.hdl.primitives.multiplier.Multiplier` at full width, without a shift:
    the same product in the same cycle.

    Members
    -------
    first, second : In(Shape(FACTOR_BITS))
    product : Out(Shape(2 * FACTOR_BITS))
        Product of the previous cycle's factors. Signed if a factor is signed.
    """

    signs: Given("(bool, bool)", "The factors that have a sign.")

    def interface(self):
        return {
            "first": In(Shape(FACTOR_BITS, self.signs[0])),
            "second": In(Shape(FACTOR_BITS, self.signs[1])),
            "product": Out(Shape(2 * FACTOR_BITS, any(self.signs))),
        }

    def elaborate(self, platform):
        m = Module()

        registers = ("INPUTA", "INPUTB", "INPUTC", "PIPELINE")
        m.submodules.primitive = Instance(
            "MULT18X18D",
            **{f"p_REG_{name}_CLK": "NONE" for name in registers},
            p_REG_OUTPUT_CLK="CLK0",
            p_REG_OUTPUT_CE="CE0",
            p_REG_OUTPUT_RST="RST0",
            p_SOURCEB_MODE="B_SHIFT",
            p_MULT_BYPASS="DISABLED",
            p_RESETMODE="SYNC",
            p_GSR="DISABLED",
            i_CLK0=ClockSignal(),
            i_CE0=Const(1),
            i_RST0=Const(0),
            i_SIGNEDA=Const(self.signs[0]),
            i_SIGNEDB=Const(self.signs[1]),
            i_SOURCEA=Const(0),
            i_SOURCEB=Const(0),
            **{f"i_A{i}": bit for i, bit in enumerate(self.first)},
            **{f"i_B{i}": bit for i, bit in enumerate(self.second)},
            **{f"i_C{i}": Const(0) for i in range(18)},
            **{f"o_P{i}": bit for i, bit in enumerate(self.product)},
        )

        return m
