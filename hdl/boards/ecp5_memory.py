"""Block RAMs of the ECP5 with their output registers, which synthesis leaves unused."""

from amaranth import *
from amaranth.utils import exact_log2

from pathgene.hdl.primitives.block_memory import memory_members
from pathgene.hdl.primitives.delay_line import delay_line
from pathgene.hdl.primitives.unit import Choice, Given, PowerOfTwo, Unit, Width


__all__ = ["Ecp5Memory"]

#: Bits of a row by the bits of its number.
_WIDTHS = {14: 1, 13: 2, 12: 4, 11: 9, 10: 18}


class Ecp5Memory(Unit):
    """Memory of DP16KD primitives side by side, with registers at their outputs.

    Twin of :class:`pathgene.hdl.primitives.block_memory.BlockMemory` with a latency of 2: the same
    ports, rows and cycles. Data of that memory leave a register of the fabric, which a block RAM of
    the device reaches 6 ns after the clock edge; data of this one are there after 1 ns. If that
    saves primitives, the memory is split into two of half the rows, and a multiplexer follows the
    registers: 4,096 rows of 9 bits take two primitives of 2,048 rows instead of three.

    Members
    -------
    a, b
        See :func:`pathgene.hdl.primitives.block_memory.memory_members`.
    """

    rows: PowerOfTwo(2, 1 << 14, name="Rows of a block")
    width: Width(1, text="Bits of a row.")
    ports: Choice(1, 2)
    sites: Given(
        "sequence of str",
        "Sites of the first primitives, in order of their bits; the placer chooses the rest.",
    ) = ()

    def interface(self):
        self.sites = tuple(self.sites)
        self._row_bits = _row_bits(self.rows)
        return memory_members(rows=self.rows, width=self.width, ports=self.ports)

    @staticmethod
    def primitives(*, rows, width):
        """Return the number of primitives of a memory."""
        parts = 2 if _is_halved(rows, width) else 1
        return parts * _side_by_side(rows // parts, width)

    def elaborate(self, platform):
        m = Module()

        if _is_halved(self.rows, self.width):
            self._join_halves(m)
            return m

        step = _WIDTHS[self._row_bits]
        for number, first in enumerate(range(0, self.width, step)):
            bits = slice(first, min(first + step, self.width))
            pins = {
                **self._port(m, "A", self.a, bits),
                **self._port(m, "B", self.b if self.ports == 2 else None, bits),
            }
            if number < len(self.sites):
                pins["a_BEL"] = self.sites[number]
            m.submodules[f"bits_{first}"] = Instance("DP16KD", **pins)

        return m

    def _join_halves(self, m):
        """Make two memories of half the rows, the lower first."""
        each = self.primitives(rows=self.rows // 2, width=self.width)
        halves = [
            Ecp5Memory(rows=self.rows // 2, width=self.width, ports=self.ports, sites=sites)
            for sites in (self.sites[:each], self.sites[each:])
        ]
        m.submodules.lower, m.submodules.upper = halves
        for name in ("a", "b")[: self.ports]:
            port = getattr(self, name)
            lower, upper = (getattr(half, name) for half in halves)
            is_upper = port.address[-1]
            m.d.comb += [
                *(half.address.eq(port.address[:-1]) for half in (lower, upper)),
                port.data.eq(
                    Mux(delay_line(m, is_upper, 2, f"is_upper_{name}"), upper.data, lower.data)
                ),
            ]
            if name == "a":
                m.d.comb += [
                    *(half.write_data.eq(port.write_data) for half in (lower, upper)),
                    lower.write_enable.eq(port.write_enable & ~is_upper),
                    upper.write_enable.eq(port.write_enable & is_upper),
                ]

    def _port(self, m, name, port, bits):
        """Return parameters and connections of one port, and drive its data."""
        row_bits = self._row_bits
        address, write, enable = Const(0, row_bits), Const(0, 18), Const(0)
        read = Signal(18, name=f"read_{name}_{bits.start}".lower())
        if port is not None:
            address = port.address
            m.d.comb += port.data[bits].eq(read)
        if name == "A":
            write, enable = port.write_data[bits], port.write_enable
        # The row number takes the upper bits; of rows of 18 bits, the lowest two enable 9 each.
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


def _row_bits(rows):
    return max(min(_WIDTHS), exact_log2(rows))


def _side_by_side(rows, width):
    """Return the primitives of a memory that is not halved."""
    return -(-width // _WIDTHS[_row_bits(rows)])


def _is_halved(rows, width):
    return rows > 1 << min(_WIDTHS) and 2 * _side_by_side(rows // 2, width) < _side_by_side(
        rows, width
    )
