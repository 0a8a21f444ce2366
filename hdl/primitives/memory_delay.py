"""Long delay line in a small memory."""

from amaranth import *
from amaranth.lib import memory
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.cells import cells_of
from pathgene.hdl.primitives.unit import Count, Given, Unit


__all__ = ["MemoryDelay"]


class MemoryDelay(Unit):
    """Delays a word by a number of steps.

    A ring of rows, read and written at the end of a step: a bit of a memory for every row where
    registers would take a flip-flop.

    Members
    -------
    step : In(1)
        A step ends with this cycle.
    word : In(shape)
        Taken in the last cycle of a step.
    delayed : Out(shape)
        The word of ``steps`` steps ago, a register.
    """

    shape: Given("ShapeLike", "Shape of a word.")
    steps: Count(2)

    def interface(self):
        return {"step": In(1), "word": In(self.shape), "delayed": Out(self.shape)}

    def elaborate(self, platform):
        m = Module()

        # Once this row is written, the next row holds the word of `steps` steps ago: no row is read
        # and written in the same cycle.
        m.submodules.rows = ring = memory.Memory(
            shape=self.shape,
            depth=self.steps,
            init=[],
            attrs={"ram_style": cells_of(platform).ram_style, "no_rw_check": 1},
        )
        write, read = ring.write_port(), ring.read_port()
        at, following = Signal(range(self.steps)), Signal(range(self.steps))
        m.d.comb += [
            following.eq(Mux(at == self.steps - 1, 0, at + 1)),
            read.addr.eq(following),
            read.en.eq(self.step),
            write.addr.eq(at),
            write.data.eq(self.word),
            write.en.eq(self.step),
            self.delayed.eq(read.data),
        ]
        with m.If(self.step):
            m.d.sync += at.eq(following)

        return m
