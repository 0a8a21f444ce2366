"""Ring buffer whose writer commits rows after writing them."""

from amaranth import *
from amaranth.lib import memory, stream
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.primitives.unit import Given, PowerOfTwo, Unit


__all__ = ["CommitRing"]


class CommitRing(Unit):
    """One block RAM between a writer that may discard rows and a stream.

    Row pointers count modulo ``2 * depth``, so that full and empty differ; a row number is a
    pointer without its highest bit. The rows from ``fetched`` up to, not including, ``committed``
    are read in order; the writer may write all remaining rows in any order and any number of times.
    It must not write a row ``depth`` or more past ``fetched``.

    A row is offered 2 cycles after ``committed`` has moved past it, then one per cycle.
    Rows are read ahead: ``fetched`` leads the transferred words by up to two.

    On a target the memory is one block RAM with an output register. Its two ports never access the
    same row in the same cycle, as ``no_rw_check`` tells synthesis.

    Members
    -------
    write_enable : In(1)
    write_row : In(log2(depth))
    write_data : In(shape)
        Row written in each cycle in which writing is enabled.
    committed : In(log2(depth) + 1)
        Pointer past the last row that may be read; it only moves forward.
    fetched : Out(log2(depth) + 1)
        Pointer to the next row to be read.
    words : Out(stream.Signature(shape))
        Rows read.
    """

    shape: Given("ShapeLike", "Shape of a row.")
    depth: PowerOfTwo(2, text="Number of rows.")

    def interface(self):
        bits = exact_log2(self.depth)
        return {
            "write_enable": In(1),
            "write_row": In(bits),
            "write_data": In(self.shape),
            "committed": In(bits + 1),
            "fetched": Out(bits + 1),
            "words": Out(stream.Signature(self.shape)),
        }

    def elaborate(self, platform):
        m = Module()

        m.submodules.rows = rows = memory.Memory(
            shape=self.shape, depth=self.depth, init=[], attrs={"no_rw_check": 1}
        )
        write = rows.write_port()
        read = rows.read_port()

        loaded = Signal()  # The read port holds a row that has not moved on.
        move_on = Signal()

        m.d.comb += [
            write.en.eq(self.write_enable),
            write.addr.eq(self.write_row),
            write.data.eq(self.write_data),
            move_on.eq(~self.words.valid | self.words.ready),
            read.en.eq((self.fetched != self.committed) & (~loaded | move_on)),
            read.addr.eq(self.fetched[:-1]),
        ]

        with m.If(read.en):
            m.d.sync += [
                self.fetched.eq(self.fetched + 1),
                loaded.eq(1),
            ]
        with m.Elif(move_on):
            m.d.sync += loaded.eq(0)
        with m.If(move_on):
            m.d.sync += [
                self.words.valid.eq(loaded),
                self.words.payload.eq(read.data),
            ]

        return m
