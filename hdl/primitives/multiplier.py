"""Products out of a multiplier's own register."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out


__all__ = ["Multiplier"]

#: Most bits of a factor that a multiplier of an ECP5 takes, signs included.
FACTOR_BITS = 18


class Multiplier(wiring.Component):
    """Multiplies two signed numbers; ``product`` follows a clock later.

    An ECP5 has the register in its multiplier, where elsewhere any that follow are taken: so no
    time is lost on the way there, nor by the multiplication on the way from there. Factors that are
    too wide for it are multiplied as elsewhere.

    Parameters
    ----------
    bits : (int, int)
        Widths of the factors.
    shift : int
        Low bits of the product to be left out.

    Members
    -------
    first, second : In(signed)
    product : Out(signed)
        ``first * second >> shift`` of the clock before.
    """

    def __init__(self, bits, shift=0):
        self.shift = shift
        first, second = bits
        super().__init__(
            {
                "first": In(signed(first)),
                "second": In(signed(second)),
                "product": Out(signed(max(1, first + second - shift))),
            }
        )

    def elaborate(self, platform):
        m = Module()

        fits = max(len(self.first), len(self.second)) <= FACTOR_BITS
        if fits and getattr(platform, "device", "").startswith("LFE5U"):
            from hdl.boards.ecp5_multiplier import Ecp5Multiplier

            m.submodules.twin = twin = Ecp5Multiplier()
            m.d.comb += [
                twin.first.eq(self.first),
                twin.second.eq(self.second),
                self.product.eq(twin.product >> self.shift),
            ]
            return m

        product = Signal.like(self.product, name="product_held", reset_less=True)
        m.d.sync += product.eq(self.first * self.second >> self.shift)
        m.d.comb += self.product.eq(product)

        return m
