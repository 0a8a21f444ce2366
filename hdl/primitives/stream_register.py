"""Stream buffer whose words come from a register."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Given, Unit


__all__ = ["StreamRegister"]


class StreamRegister(Unit):
    """Puts registers in the path of ``valid`` and ``payload``; ``ready`` passes through.

    A word is offered a cycle after it is taken; it does not add pauses to a stream.

    Members
    -------
    words : In(stream.Signature(shape))
    passed : Out(stream.Signature(shape))
        The same words; ``valid`` and ``payload`` are registers.
    """

    shape: Given("ShapeLike", "Shape of a word.")

    def interface(self):
        return {
            "words": In(stream.Signature(self.shape)),
            "passed": Out(stream.Signature(self.shape)),
        }

    def elaborate(self, platform):
        m = Module()

        m.d.comb += self.words.ready.eq(~self.passed.valid | self.passed.ready)
        payload = Signal(self.shape, reset_less=True)
        m.d.comb += self.passed.payload.eq(payload)
        with m.If(self.words.ready):
            m.d.sync += [
                self.passed.valid.eq(self.words.valid),
                payload.eq(self.words.payload),
            ]

        return m
