"""Multiplier with a register at its output."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.cells import cells_of
from pathgene.hdl.primitives.unit import Count, Given, Unit


__all__ = ["Multiplier"]


class Multiplier(Unit):
    """Multiplies two numbers; ``product`` follows a cycle later.

    If the platform has a multiplier cell for such factors
    (:meth:`pathgene.hdl.primitives.cells.Cells.multiplier`), the register lies within the cell:
    there is no routing between product and register.

    Members
    -------
    first, second : In(Shape)
    product : Out(Shape)
        ``first * second >> shift`` of the previous cycle. Signed if a factor is signed.
    """

    widths: Given("(int, int)", "Widths of the factors.")
    shift: Count(0, text="Low bits of the product that are left out.") = 0
    signs: Given("(bool, bool)", "The factors that have a sign.") = (True, True)

    def interface(self):
        return {
            "first": In(Shape(self.widths[0], self.signs[0])),
            "second": In(Shape(self.widths[1], self.signs[1])),
            "product": Out(Shape(max(1, sum(self.widths) - self.shift), any(self.signs))),
        }

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
