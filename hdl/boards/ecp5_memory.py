"""Block RAMs of the ECP5: the registers in them, which synthesis leaves unused, and their sites."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.utils import exact_log2

from hdl.boards.ecp5_floor_plan import MAP_SITES
from hdl.feasibility.map_block import block_members


__all__ = ["Ecp5Memory"]

#: Bits of a row by the bits of its number.
_WIDTHS = {14: 1, 13: 2, 12: 4, 11: 9, 10: 18}


class Ecp5Memory(wiring.Component):
    """Memory of DP16KD primitives, side by side, whose data are in registers at their outputs.

    Twin of :class:`hdl.feasibility.map_block.MapBlock` with a latency of 2: the same ports,
    rows and clocks. There a register anywhere on the device follows 6 ns after the clock and some
    of wire; here the data are there 1 ns after it.

    A map takes nearly all block RAMs of the device. Left to itself, the placer spreads those of a
    block over the whole die, and each row address has to reach them all. With a ``place`` the
    primitives of a block are neighbours.

    Parameters
    ----------
    rows : int
        A power of two, 2..16384.
    width : int
        Bits of a row.
    ports : int
        1 or 2.
    place : int or None
        Number of this block among others of its size: it has the sites after those of the blocks
        before it, as long as there are :data:`MAP_SITES`. None leaves that to the placer.

    Members
    -------
    a, b
        See :func:`hdl.feasibility.map_block.block_members`.

    Raises
    ------
    ValueError
        If there are too many rows.
    """

    def __init__(self, *, rows, width, ports, place=None):
        if rows > 1 << 14:
            raise ValueError(f"Rows of a block must be at most 16384, not {rows!r}")

        self.rows = rows
        self.width = width
        self.ports = ports
        self.place = place
        super().__init__(block_members(rows=rows, width=width, ports=ports))

    def elaborate(self, platform):
        m = Module()

        row_bits = max(10, exact_log2(self.rows))
        step = _WIDTHS[row_bits]
        firsts = range(0, self.width, step)
        sites = ()
        if self.place is not None:
            sites = MAP_SITES[len(firsts) * self.place :][: len(firsts)]
        for number, first in enumerate(firsts):
            bits = slice(first, min(first + step, self.width))
            pins = {
                **self._port(m, "A", self.a, row_bits, bits),
                **self._port(m, "B", self.b if self.ports == 2 else None, row_bits, bits),
            }
            if number < len(sites):
                pins["a_BEL"] = sites[number]
            m.submodules[f"bits_{first}"] = Instance("DP16KD", **pins)

        return m

    def _port(self, m, name, port, row_bits, bits):
        """Return parameters and connections of one port, and drive its data."""
        address, write, enable = Const(0, row_bits), Const(0, 18), Const(0)
        read = Signal(18, name=f"read_{name}_{bits.start}".lower())
        if port is not None:
            address = port.address
            m.d.comb += port.data[bits].eq(read)
        if name == "A":
            write, enable = port.write_data[bits], port.write_enable
        # Rows are counted in the upper bits; with 18 bits, the lowest two are enables of 9 each.
        lowest = enable.replicate(2) if row_bits == 10 else Const(0, 2)
        below = Cat(lowest, Const(0, 2))[: 14 - row_bits]
        address = Cat(below, address, Const(0, row_bits - len(address)))
        write = Cat(write, Const(0, 18 - len(write)))
        return {
            f"p_DATA_WIDTH_{name}": _WIDTHS[row_bits],
            f"p_REGMODE_{name}": "OUTREG",
            f"p_WRITEMODE_{name}": "READBEFOREWRITE",
            f"p_CSDECODE_{name}": "0b000",
            "p_RESETMODE": "ASYNC",
            "p_GSR": "DISABLED",
            f"i_CLK{name}": ClockSignal(),
            f"i_CE{name}": Const(1),
            f"i_OCE{name}": Const(1),
            f"i_RST{name}": Const(0),
            f"i_WE{name}": enable,
            **{f"i_CS{name}{i}": Const(0) for i in range(3)},
            **{f"i_AD{name}{i}": bit for i, bit in enumerate(address)},
            **{f"i_DI{name}{i}": bit for i, bit in enumerate(write)},
            **{f"o_DO{name}{i}": bit for i, bit in enumerate(read)},
        }
