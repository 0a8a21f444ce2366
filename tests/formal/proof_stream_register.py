"""The stream register passes every word on, once and in order."""

from amaranth import *
from amaranth.hdl import Assert, Cover

from pathgene.hdl.primitives.buffers import StreamRegister
from tests.formal.parts import Scoreboard, free
from tools.formal import Proof


class Register(Elaboratable):
    """Proved for all time, by induction; the source and the sink are free.

    - The words of 8 bits that leave are those that entered: none lost, invented, altered or moved.
    - At most one word is inside, and one that is inside is offered.
    - A word is taken in every cycle in which none is inside or the one that is leaves.
    """

    def __init__(self, unit):
        self.dut = unit(StreamRegister)(8)

    def elaborate(self, platform):
        m = Module()
        words, passed = self.dut.words, self.dut.passed
        m.submodules.dut = self.dut
        m.submodules.board = board = Scoreboard(8, 3)
        free(m, words.valid, words.payload, passed.ready)
        m.d.comb += [
            board.put.eq(words.valid & words.ready),
            board.put_word.eq(words.payload),
            board.take.eq(passed.valid & passed.ready),
            board.take_word.eq(passed.payload),
            Assert(board.inside == passed.valid),
            Assert(words.ready == ((board.inside == 0) | passed.ready)),
            Cover((board.taken == 5) & (board.inside == 1) & (board.watched == 5)),
        ]
        with m.If(passed.valid & (board.taken == board.watched)):
            m.d.comb += Assert(passed.payload == board.value)
        return m


PROOF = Proof(
    claim=Register,
    depth=12,
    induction=2,
    faults={
        "a word is lost where another leaves": (
            StreamRegister,
            (
                "self.passed.valid.eq(self.words.valid)",
                "self.passed.valid.eq(self.words.valid & ~self.passed.valid)",
            ),
        ),
        "a word that waits is overwritten": (
            StreamRegister,
            ("(~self.passed.valid | self.passed.ready)", "(~self.passed.valid | self.words.valid)"),
        ),
    },
)
