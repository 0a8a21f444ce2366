"""Square root of an integer, rounded down."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.primitives.arguments import check_integer


__all__ = ["SquareRoot"]


class SquareRoot(wiring.Component):
    """Square root of a number in every cycle, rounded down.

    Digit by digit: each stage takes two bits of the radicand and yields one of the root. ``root``
    follows ``width`` cycles after its radicand.

    Parameters
    ----------
    width : int
        Bits of a root, 1 or more.

    Attributes
    ----------
    latency : int
        Cycles from a radicand to its root.

    Members
    -------
    radicand : In(2 * width)
    root : Out(width)

    Raises
    ------
    TypeError, ValueError
        If the width is not an integer, or less than 1.
    """

    def __init__(self, width):
        check_integer("Root width", width, 1)
        self.width = self.latency = width
        super().__init__({"radicand": In(2 * width), "root": Out(width)})

    def elaborate(self, platform):
        m = Module()

        # Of the bits taken: their root, and what they are above its square, at most twice the root.
        # Root and remainder of the first stage begin without bits.
        root, remainder, rest = Const(0, 0), Const(0, 0), self.radicand
        for digit in range(1, self.width + 1):
            following = 2 * (self.width - digit)
            raised = Cat(rest[following:], remainder)
            beyond = Signal(signed(digit + 3), name=f"beyond_{digit}")
            fits = Signal(name=f"fits_{digit}")
            next_root = Signal(digit, name=f"root_{digit}", reset_less=True)
            next_remainder = Signal(digit + 1, name=f"remainder_{digit}", reset_less=True)
            m.d.comb += [
                beyond.eq(raised - Cat(C(1, 2), root)),
                fits.eq(beyond >= 0),
            ]
            m.d.sync += [
                next_root.eq(Cat(fits, root)),
                next_remainder.eq(Mux(fits, beyond, raised)),
            ]
            if following:
                next_rest = Signal(following, name=f"rest_{digit}", reset_less=True)
                m.d.sync += next_rest.eq(rest)
                rest = next_rest
            root, remainder = next_root, next_remainder
        m.d.comb += self.root.eq(root)

        return m
