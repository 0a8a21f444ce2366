"""Long delay line in a small memory."""

from amaranth import *
from amaranth.lib import memory, wiring
from amaranth.lib.wiring import In, Out

from hdl.primitives.arguments import check_integer


__all__ = ["MemoryDelay"]


class MemoryDelay(wiring.Component):
    """Delays a word by a number of steps.

    A ring of rows, read at once and written at the end of a step; a family's small memories take
    it, at a bit for every row where registers would take a flip-flop.

    Parameters
    ----------
    shape : ShapeLike
        Shape of a word.
    steps : int
        2 or more.

    Members
    -------
    step : In(1)
        A step ends with this cycle.
    word : In(shape)
        Taken in the last cycle of a step.
    delayed : Out(shape)
        The word of ``steps`` steps ago, a register.

    Raises
    ------
    TypeError, ValueError
        If ``steps`` is not an integer, or less than 2.
    """

    def __init__(self, shape, steps):
        check_integer("Steps", steps, 2)
        self.shape = shape
        self.steps = steps
        super().__init__({"step": In(1), "word": In(shape), "delayed": Out(shape)})

    def elaborate(self, platform):
        m = Module()

        # The register of the output is one of the steps.
        rows = self.steps - 1
        m.submodules.rows = ring = memory.Memory(
            shape=self.shape, depth=rows, init=[], attrs={"ram_style": "distributed"}
        )
        write, read = ring.write_port(), ring.read_port(domain="comb")
        at = Signal(range(rows))
        delayed = Signal(self.shape, reset_less=True)
        m.d.comb += [
            read.addr.eq(at),
            write.addr.eq(at),
            write.data.eq(self.word),
            write.en.eq(self.step),
            self.delayed.eq(delayed),
        ]
        with m.If(self.step):
            m.d.sync += [delayed.eq(read.data), at.eq(Mux(at == rows - 1, 0, at + 1))]

        return m
