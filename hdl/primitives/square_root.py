"""Square root of an integer, rounded down."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.add_subtract import AddSubtract
from pathgene.hdl.primitives.unit import Unit, Width


__all__ = ["SquareRoot"]


class SquareRoot(Unit):
    """Square root of a number in every cycle, rounded down.

    Digit by digit: each stage takes two bits of the radicand and yields one bit of the root.
    ``root`` follows ``width`` cycles after its radicand.

    Attributes
    ----------
    latency : int
        Cycles from a radicand to its root.

    Members
    -------
    radicand : In(2 * width)
    root : Out(width)
    """

    width: Width(1, name="Root width")

    def interface(self):
        self.latency = self.width
        return {"radicand": In(2 * self.width), "root": Out(self.width)}

    def elaborate(self, platform):
        m = Module()

        # `root` and `remainder` belong to the bits taken; the remainder is at most twice the root.
        # If it is negative, the last bit of the root is 0; the next digit adds the excess back and
        # need not restore it. Before the first digit, the root has no bits.
        root, remainder, rest = Const(0, 0), Const(0, 1), self.radicand
        for digit in range(1, self.width + 1):
            following = 2 * (self.width - digit)
            negative = remainder[-1]
            m.submodules[f"digit_{digit}"] = chain = AddSubtract(digit + 2)
            m.d.comb += [
                chain.first.eq(Cat(rest[following:], remainder)),
                # Subtract 4 root + 1; after a negative remainder, add 4 root + 3.
                chain.second.eq(Cat(C(1, 1), negative, root)),
                chain.subtracts.eq(~negative),
            ]
            next_root = Signal(digit, name=f"root_{digit}", reset_less=True)
            m.d.sync += next_root.eq(Cat(~chain.total[-1], root))
            root = next_root
            if following:
                next_remainder = Signal(digit + 2, name=f"remainder_{digit}", reset_less=True)
                next_rest = Signal(following, name=f"rest_{digit}", reset_less=True)
                m.d.sync += [next_remainder.eq(chain.total), next_rest.eq(rest)]
                remainder, rest = next_remainder, next_rest
        m.d.comb += self.root.eq(root)

        return m
