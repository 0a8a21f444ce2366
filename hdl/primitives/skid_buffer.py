"""Stream buffer whose ``ready`` comes from a register."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Given, Unit


__all__ = ["SkidBuffer"]


class SkidBuffer(Unit):
    """Breaks a chain of ``ready`` signals: takes one word that it cannot pass on, and keeps it.

    An empty buffer passes words through in the same cycle, with ``ready`` high regardless of
    ``passed.ready``; it does not cost a cycle or add pauses to a stream.

    Members
    -------
    words : In(stream.Signature(shape))
        ``ready`` is a register.
    passed : Out(stream.Signature(shape))
        The same words. ``valid`` and ``payload`` come through one multiplexer from ``words``.
    """

    shape: Given("ShapeLike", "Shape of a word.")

    def interface(self):
        return {
            "words": In(stream.Signature(self.shape)),
            "passed": Out(stream.Signature(self.shape)),
        }

    def elaborate(self, platform):
        m = Module()

        empty = Signal(init=1)
        kept = Signal(self.shape, reset_less=True)
        m.d.comb += [
            self.words.ready.eq(empty),
            self.passed.valid.eq(self.words.valid | ~empty),
            self.passed.payload.eq(Mux(empty, self.words.payload, kept)),
        ]
        with m.If(self.passed.ready):
            m.d.sync += empty.eq(1)
        with m.Elif(self.words.valid):
            m.d.sync += empty.eq(0)
        with m.If(empty):
            m.d.sync += kept.eq(self.words.payload)

        return m
