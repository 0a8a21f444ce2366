"""Adder that subtracts where it is told to."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.arguments import check_integer
from pathgene.hdl.primitives.cells import cells_of


__all__ = ["AddSubtract"]


class AddSubtract(wiring.Component):
    """Sum or difference of two numbers modulo ``2**width``, without a register.

    One carry chain does both on a platform with a cell for it
    (:meth:`pathgene.hdl.primitives.cells.Cells.add_subtract`); synthesis alone makes two, and a
    choice.

    Parameters
    ----------
    width : int
        1 or more.

    Members
    -------
    first, second : In(width)
    subtracts : In(1)
    total : Out(width)
        ``first - second`` with ``subtracts``, otherwise ``first + second``.

    Raises
    ------
    TypeError, ValueError
        If the width is not an integer, or less than 1.
    """

    def __init__(self, width):
        check_integer("Width", width, 1)
        self.width = width
        super().__init__(
            {
                "first": In(width),
                "second": In(width),
                "subtracts": In(1),
                "total": Out(width),
            }
        )

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
