"""Queue in a memory without registers at its output."""

from amaranth import *
from amaranth.lib import memory, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.primitives.arguments import check_integer


__all__ = ["MemoryQueue"]


class MemoryQueue(wiring.Component):
    """First-in, first-out queue; a word is offered in the cycle after it is put in.

    The memory is read within a cycle: on a target it consists of LUTs.

    Parameters
    ----------
    shape : ShapeLike
        Shape of a word.
    depth : int
        Words that fit, 1 or more. A further word is lost.

    Members
    -------
    clear : In(1)
        Empty the queue. Overrides the rest.
    put : In(1)
        Put ``word`` in, if there is room.
    word : In(shape)
    words : Out(stream.Signature(shape))

    Raises
    ------
    TypeError, ValueError
        If ``depth`` is not an integer, or out of its range.
    """

    def __init__(self, shape, depth):
        check_integer("Depth", depth, 1)

        self.shape = shape
        self.depth = depth
        super().__init__(
            {
                "clear": In(1),
                "put": In(1),
                "word": In(shape),
                "words": Out(stream.Signature(shape)),
            }
        )

    def elaborate(self, platform):
        m = Module()

        m.submodules.rows = rows = memory.Memory(shape=self.shape, depth=self.depth, init=[])
        write, read = rows.write_port(), rows.read_port(domain="comb")
        m.d.comb += [
            write.data.eq(self.word),
            write.en.eq(self.put),
            self.words.payload.eq(read.data),
        ]
        takes = self.words.valid & self.words.ready
        for port, moved in ((write, self.put), (read, takes)):
            with m.If(moved):
                m.d.sync += port.addr.eq(Mux(port.addr == self.depth - 1, 0, port.addr + 1))
        # A register, since who takes a word often decides late.
        left, is_single = Signal(range(self.depth + 1)), Signal()
        with m.If(self.put & ~takes):
            m.d.sync += [left.eq(left + 1), is_single.eq(left == 0), self.words.valid.eq(1)]
        with m.Elif(takes & ~self.put):
            m.d.sync += [
                left.eq(left - 1),
                is_single.eq(left == 2),
                self.words.valid.eq(~is_single),
            ]
        with m.If(self.clear):
            m.d.sync += [
                *(port.addr.eq(0) for port in (write, read)),
                left.eq(0),
                self.words.valid.eq(0),
            ]

        return m
