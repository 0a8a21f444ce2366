"""Multiplier with a register at its output."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.cells import cells_of


__all__ = ["Multiplier"]


class Multiplier(wiring.Component):
    """Multiplies two numbers; ``product`` follows a cycle later.

    The register is that of the platform's multiplier cell where there is one for such factors
    (:meth:`pathgene.hdl.primitives.cells.Cells.multiplier`): no routing lies between product and
    register.

    Parameters
    ----------
    widths : (int, int)
        Of the factors.
    shift : int
        Low bits of the product to be left out.
    signs : (bool, bool)
        The factors that have a sign.

    Members
    -------
    first, second : In(Shape)
    product : Out(Shape)
        ``first * second >> shift`` of the cycle before. It has a sign if a factor has one.
    """

    def __init__(self, widths, shift=0, signs=(True, True)):
        self.widths = widths
        self.shift = shift
        self.signs = signs
        super().__init__(
            {
                "first": In(Shape(widths[0], signs[0])),
                "second": In(Shape(widths[1], signs[1])),
                "product": Out(Shape(max(1, sum(widths) - shift), any(signs))),
            }
        )

    def elaborate(self, platform):
        m = Module()

        cell = cells_of(platform).multiplier(self.widths, self.signs)
        if cell is not None:
            m.submodules.hard = cell
            m.d.comb += [
                cell.first.eq(self.first),
                cell.second.eq(self.second),
                self.product.eq(cell.product >> self.shift),
            ]
            return m

        product = Signal.like(self.product, name="product_held", reset_less=True)
        m.d.sync += product.eq(self.first * self.second >> self.shift)
        m.d.comb += self.product.eq(product)

        return m
