"""Stream buffer whose words come from a register."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out


__all__ = ["StreamRegister"]


class StreamRegister(wiring.Component):
    """Puts registers in the path of ``valid`` and ``payload``; ``ready`` passes through.

    A word is offered a cycle after it is taken; a stream without a pause stays one.

    Parameters
    ----------
    shape : ShapeLike
        Shape of a word.

    Members
    -------
    words : In(stream.Signature(shape))
    passed : Out(stream.Signature(shape))
        The same words; ``valid`` and ``payload`` are registers.
    """

    def __init__(self, shape):
        self.shape = shape
        super().__init__(
            {"words": In(stream.Signature(shape)), "passed": Out(stream.Signature(shape))}
        )

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
