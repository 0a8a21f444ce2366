"""Divider of integers, rounding down."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.add_subtract import AddSubtract
from pathgene.hdl.primitives.unit import Unit, Width


__all__ = ["Divider"]


class Divider(Unit):
    """Quotient of two unsigned numbers in every cycle, rounded down.

    A stage adds or subtracts the divisor once and yields one bit (non-restoring division).
    ``quotient`` follows ``quotient_bits`` cycles after its dividend. It is undefined where it has
    more bits, or the divisor is 0.

    Attributes
    ----------
    latency : int
        Cycles from a dividend to its quotient.

    Members
    -------
    dividend : In(divisor_bits + quotient_bits)
        Less than ``divisor << quotient_bits``.
    divisor : In(divisor_bits)
    quotient : Out(quotient_bits)
    """

    divisor_bits: Width(1)
    quotient_bits: Width(1)

    def interface(self):
        self.latency = self.quotient_bits
        return {
            "dividend": In(self.divisor_bits + self.quotient_bits),
            "divisor": In(self.divisor_bits),
            "quotient": Out(self.quotient_bits),
        }

    def elaborate(self, platform):
        m = Module()

        width, bits = self.divisor_bits, self.quotient_bits
        divisor = self.divisor
        # `rest` holds the remaining bits of the dividend above the bits of the quotient. A
        # remainder may be negative: the next stage then adds, and need not restore it. It is at
        # least -divisor and less than divisor, so that it fits in a bit more.
        rest, remainder = self.dividend[:bits], Cat(self.dividend[bits:], C(0))
        for stage in range(1, bits + 1):
            m.submodules[f"stage_{stage}"] = chain = AddSubtract(width + 1)
            m.d.comb += [
                chain.first.eq(Cat(rest[-1], remainder)),
                chain.second.eq(divisor),
                chain.subtracts.eq(~remainder[-1]),
            ]
            next_rest = Signal(bits, name=f"rest_{stage}", reset_less=True)
            m.d.sync += next_rest.eq(Cat(~chain.total[-1], rest))
            rest = next_rest
            if stage < bits:
                next_remainder = Signal(width + 1, name=f"remainder_{stage}", reset_less=True)
                next_divisor = Signal(width, name=f"divisor_{stage}", reset_less=True)
                m.d.sync += [next_remainder.eq(chain.total), next_divisor.eq(divisor)]
                remainder, divisor = next_remainder, next_divisor
        m.d.comb += self.quotient.eq(rest)

        return m
