"""The ring buffer of the link reads every committed row, once and in order."""

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover
from amaranth.utils import exact_log2

from pathgene.hdl.primitives.storage import CommitRing
from tests.formal.parts import Opened, any_constant, free
from tools.formal import Proof


class Ring(Elaboratable):
    """Proved for all time, by induction, for a ring of 4 rows of 8 bits.

    Assumed of the writer: it does not write a row that is committed and not yet fetched, and
    ``committed`` moves forward, in each cycle by any number of rows up to those that the ring has.
    The reader is free.

    - The words transferred are the rows in order, each as it was written last before it was
      committed: none lost, none twice, none invented.
    - At most two rows are fetched and not transferred.
    - A row is offered 2 cycles after it was committed, if the words before it are taken.
    """

    DEPTH = 4

    def __init__(self, unit):
        self.dut = unit(CommitRing)(8, self.DEPTH)

    def elaborate(self, platform):
        m = Module()
        ring, depth = self.dut, self.DEPTH
        pointer = unsigned(exact_log2(depth) + 1)
        m.submodules.dut = dut = Opened(ring)
        watched = any_constant(m, pointer, "watched")
        stored = dut.memory(m, "rows", watched[:-1])
        loaded = dut.signal("loaded")

        # The environment.
        committed, move = Signal(pointer), Signal(pointer)
        filled, ahead = Signal(pointer), Signal(pointer)
        free(m, ring.write_enable, ring.write_row, ring.write_data, ring.words.ready, move)
        m.d.sync += committed.eq(committed + move)
        m.d.comb += [
            ring.committed.eq(committed),
            filled.eq(committed - ring.fetched),
            ahead.eq((ring.write_row - ring.fetched)[:-1]),
            Assume(~ring.write_enable | (ahead[: len(ring.write_row)] >= filled)),
            Assume(filled + move <= depth),
        ]

        # The row watched: its latest text, and that with which it was fetched.
        taken, behind = Signal(pointer), Signal(pointer)
        text, expected = Signal(8), Signal(8)
        transfer = Signal()
        m.d.comb += [
            behind.eq(ring.fetched - taken),
            transfer.eq(ring.words.valid & ring.words.ready),
        ]
        m.d.sync += taken.eq(taken + transfer)
        with m.If(ring.write_enable & (ring.write_row == watched[:-1])):
            m.d.sync += text.eq(ring.write_data)
        with m.If((ring.fetched == watched) & (filled != 0)):
            m.d.sync += expected.eq(text)

        m.d.comb += [
            Assert(filled <= depth),
            Assert(behind == loaded + ring.words.valid),
            Assert(stored == text),
        ]
        with m.If(transfer & (taken == watched)):
            m.d.comb += Assert(ring.words.payload == expected)

        # Invariants of words in flight, for the induction.
        with m.If(ring.words.valid & (taken == watched)):
            m.d.comb += Assert(ring.words.payload == expected)
        with m.If(loaded & (Value.cast(taken + ring.words.valid)[: len(taken)] == watched)):
            m.d.comb += Assert(dut.submodules.rows.read_ports[0].data == expected)

        # Nothing but a word that is not taken keeps a row waiting.
        waiting = Signal(range(4))
        with m.If((filled == 0) & ~loaded | ring.words.valid):
            m.d.sync += waiting.eq(0)
        with m.Else():
            m.d.sync += waiting.eq(waiting + 1)
        m.d.comb += [
            Assert(waiting <= 2),
            Assert((waiting != 1) | loaded | ring.words.valid),
            Assert((waiting != 2) | ring.words.valid),
            Cover((taken == 5) & (filled == depth) & (behind == 2)),
        ]
        return m


PROOF = Proof(
    claim=Ring,
    depth=12,
    induction=3,
    reached=20,
    faults={
        "a row is fetched over one that waits": (
            CommitRing,
            (" & (~loaded | move_on)", ""),
        ),
        "rows that are not committed are read": (
            CommitRing,
            ("(self.fetched != self.committed)", "(self.fetched[:-1] != self.committed[:-1])"),
        ),
        "a word is offered twice": (
            CommitRing,
            ("self.words.valid.eq(loaded)", "self.words.valid.eq(loaded | read.en)"),
        ),
    },
)
