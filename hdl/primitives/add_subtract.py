"""Adder that can also subtract."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.cells import cells_of
from pathgene.hdl.primitives.unit import Unit, Width


__all__ = ["AddSubtract"]


class AddSubtract(Unit):
    """Sum or difference of two numbers modulo ``2**width``, without a register.

    One carry chain does both on a platform with a cell for it
    (:meth:`pathgene.hdl.primitives.cells.Cells.add_subtract`); synthesis by itself makes two chains
    and a multiplexer.

    Members
    -------
    first, second : In(width)
    subtracts : In(1)
    total : Out(width)
        ``first - second`` with ``subtracts``, otherwise ``first + second``.
    """

    width: Width(1)

    def interface(self):
        return {
            "first": In(self.width),
            "second": In(self.width),
            "subtracts": In(1),
            "total": Out(self.width),
        }

    def elaborate(self, platform):
        m = Module()

        first, second, subtracts = self.first, self.second, self.subtracts
        cell = cells_of(platform).add_subtract(self.width)
        if cell is None:
            m.d.comb += self.total.eq(Mux(subtracts, first - second, first + second))
            return m

        m.submodules.hard = cell
        m.d.comb += [
            cell.first.eq(first),
            cell.second.eq(second),
            cell.subtracts.eq(subtracts),
            self.total.eq(cell.total),
        ]
        return m
