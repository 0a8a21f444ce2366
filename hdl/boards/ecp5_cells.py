"""Hard cells of the ECP5: adders, multipliers and block RAMs, with the registers inside them."""

from collections.abc import Sequence

from amaranth import *
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.primitives.cells import Cells
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.storage import memory_members
from pathgene.hdl.primitives.unit import Choice, Given, PowerOfTwo, Unit, Width


__all__ = ["FACTOR_BITS", "Ecp5AddSubtract", "Ecp5Cells", "Ecp5Memory", "Ecp5Multiplier"]


class Ecp5AddSubtract(Unit):
    """Twin of ``AddSubtract``, with the same parameter and members.

    Synthesis maps it using ``ecp5_arithmetic.v``.
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

        m.submodules.primitive = Instance(
            "ADD_OR_SUBTRACT",
            p_WIDTH=self.width,
            i_first=self.first,
            i_second=self.second,
            i_subtracts=self.subtracts,
            o_total=self.total,
        )

        return m


#: Maximum bits of a factor, including its sign if it is signed.
FACTOR_BITS = 18


class Ecp5Multiplier(Unit):
    """One MULT18X18D with a register at its output.

    Twin of :class:`pathgene.hdl.primitives.arithmetic.Multiplier` at full width, without a shift:
    the same product in the same cycle.

    Members
    -------
    first, second : In(Shape(FACTOR_BITS))
    product : Out(Shape(2 * FACTOR_BITS))
        Product of the previous cycle's factors, signed if a factor is signed.
    """

    signs: Given("(bool, bool)", "The factors that have a sign.")

    def interface(self):
        return {
            "first": In(Shape(FACTOR_BITS, self.signs[0])),
            "second": In(Shape(FACTOR_BITS, self.signs[1])),
            "product": Out(Shape(2 * FACTOR_BITS, any(self.signs))),
        }

    def elaborate(self, platform):
        m = Module()

        registers = ("INPUTA", "INPUTB", "INPUTC", "PIPELINE")
        m.submodules.primitive = Instance(
            "MULT18X18D",
            **{f"p_REG_{name}_CLK": "NONE" for name in registers},
            p_REG_OUTPUT_CLK="CLK0",
            p_REG_OUTPUT_CE="CE0",
            p_REG_OUTPUT_RST="RST0",
            p_SOURCEB_MODE="B_SHIFT",
            p_MULT_BYPASS="DISABLED",
            p_RESETMODE="SYNC",
            p_GSR="DISABLED",
            i_CLK0=ClockSignal(),
            i_CE0=Const(1),
            i_RST0=Const(0),
            i_SIGNEDA=Const(self.signs[0]),
            i_SIGNEDB=Const(self.signs[1]),
            i_SOURCEA=Const(0),
            i_SOURCEB=Const(0),
            **{f"i_A{i}": bit for i, bit in enumerate(self.first)},
            **{f"i_B{i}": bit for i, bit in enumerate(self.second)},
            **{f"i_C{i}": Const(0) for i in range(18)},
            **{f"o_P{i}": bit for i, bit in enumerate(self.product)},
        )

        return m


#: Width of a row, by the width of its address.
_WIDTHS = {14: 1, 13: 2, 12: 4, 11: 9, 10: 18}


class Ecp5Memory(Unit):
    """Memory of DP16KD primitives side by side, with registers at their outputs.

    Twin of :class:`pathgene.hdl.primitives.storage.BlockMemory` with a latency of 2: the same
    ports, rows and cycles. Data of that memory come from a register in the fabric, which a block
    RAM of the device reaches 6 ns after the clock edge; data of this memory are available after 1
    ns. If that saves primitives, the memory is split into two memories of half the rows, and a
    multiplexer follows the registers: 4,096 rows of 9 bits take two primitives of 2,048 rows
    instead of three.

    Members
    -------
    a, b
        See :func:`pathgene.hdl.primitives.storage.memory_members`.
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
        """Make two memories of half the rows, the lower half first."""
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
        # The row number uses the upper bits; for rows of 18 bits, the lowest two bits enable 9 bits
        # each.
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
    """Return the primitives of a memory that is not split."""
    return -(-width // _WIDTHS[_row_bits(rows)])


def _is_halved(rows, width):
    return rows > 1 << min(_WIDTHS) and 2 * _side_by_side(rows // 2, width) < _side_by_side(
        rows, width
    )


#: Maximum bits of a factor for which the product is left to logic: two or three additions are no
#: slower than the route to a multiplier and back. Parts of wide products are this narrow.
_NARROW = 3
#: Maximum bits of both factors if logic is scarce.
_TINY = 8


class Ecp5Cells(Cells):
    """Cells of an ECP5.

    Parameters
    ----------
    sites : sequence of str
        Sites of block RAMs, in the order in which numbered memories take them; the placer chooses
        sites for memories past the end, and for all memories if the list is empty.
    saves_logic : bool
        Use multipliers for narrow products too, and block RAMs for long delays and tables: for a
        device with more of these to spare than logic.
    """

    def __init__(self, sites: Sequence[str] = (), *, saves_logic: bool = False) -> None:
        self.sites = tuple(sites)
        self.saves_logic = saves_logic
        self.ram_style = "block" if saves_logic else "distributed"

    def memory(self, *, rows: int, width: int, ports: int, number: int | None) -> Ecp5Memory:
        """Return a memory of DP16KD primitives; its sites follow the lower-numbered memories."""
        sites = ()
        if number is not None:
            each = Ecp5Memory.primitives(rows=rows, width=width)
            sites = self.sites[number * each :][:each]
        return Ecp5Memory(rows=rows, width=width, ports=ports, sites=sites)

    def multiplier(
        self, widths: tuple[int, int], signs: tuple[bool, bool]
    ) -> Ecp5Multiplier | None:
        """Return a MULT18X18D, or None if a factor is too wide or too narrow for it."""
        is_small = sum(widths) <= _TINY if self.saves_logic else min(widths) <= _NARROW
        return None if is_small or max(widths) > FACTOR_BITS else Ecp5Multiplier(signs)

    def add_subtract(self, width: int) -> Ecp5AddSubtract:
        """Return a carry chain."""
        return Ecp5AddSubtract(width)
