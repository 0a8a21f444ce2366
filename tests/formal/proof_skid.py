"""The skid buffer passes every word on, once and in order, and keeps at most one."""

from amaranth import *
from amaranth.hdl import Assert, Cover

from pathgene.hdl.primitives.buffers import SkidBuffer
from tests.formal.parts import Opened, Scoreboard, free
from tools.formal import Proof


class Skid(Elaboratable):
    """Proved for all time, by induction; the source and the sink are free.

    - The words of 8 bits that leave are those that entered: none lost, invented, altered or moved.
    - At most one word is inside, and one that is inside is offered.
    - ``ready`` comes from a register: it is high exactly when no word is inside.
    """

    def __init__(self, unit):
        self.dut = unit(SkidBuffer)(8)

    def elaborate(self, platform):
        m = Module()
        words, passed = self.dut.words, self.dut.passed
        m.submodules.dut = dut = Opened(self.dut)
        m.submodules.board = board = Scoreboard(8, 3)
        free(m, words.valid, words.payload, passed.ready)
        m.d.comb += [
            board.put.eq(words.valid & words.ready),
            board.put_word.eq(words.payload),
            board.take.eq(passed.valid & passed.ready),
            board.take_word.eq(passed.payload),
            Assert(words.ready == (board.inside == 0)),
            Assert(board.inside <= 1),
            Assert((board.inside == 0) | passed.valid),
            Cover((board.taken == 5) & (board.inside == 1) & (board.watched == 5)),
        ]
        with m.If((board.inside == 1) & (board.taken == board.watched)):
            m.d.comb += Assert(dut.signal("kept") == board.value)
        return m


PROOF = Proof(
    claim=Skid,
    depth=12,
    induction=2,
    faults={
        "a word is kept that was passed on": (
            SkidBuffer,
            ("with m.If(self.passed.ready):", "with m.If(self.passed.ready & ~self.words.valid):"),
        ),
        "the kept word is overwritten": (SkidBuffer, ("with m.If(empty):", "with m.If(1):")),
    },
)
