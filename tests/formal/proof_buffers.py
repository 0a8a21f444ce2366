"""Skid buffer, stream register, result queue and ring pass every word on, once and in order."""

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover
from amaranth.utils import exact_log2

from pathgene.hdl.primitives.buffers import ResultQueue, SkidBuffer, StreamRegister
from pathgene.hdl.primitives.storage import CommitRing
from tests.formal.parts import Opened, Scoreboard, any_constant, free
from tools.formal import Proof


class Skid(Elaboratable):
    """Proved for all time, by induction; the source and the sink are free.

    - The words of 8 bits that leave are the words that entered: none lost, invented, altered or
      moved.
    - At most one word is inside, and it is offered.
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


SKID = Proof(
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


class Register(Elaboratable):
    """Proved for all time, by induction; the source and the sink are free.

    - The words of 8 bits that leave are the words that entered: none lost, invented, altered or
      moved.
    - At most one word is inside, and it is offered.
    - A word is taken in every cycle in which none is inside or the word inside leaves.
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


STREAM_REGISTER = Proof(
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


class Queue(Elaboratable):
    """Proved for all time, by induction, for a queue of 3 words of 8 bits; the sink is free.

    Assumed of the source: it does not put in a word while 3 are inside.

    - The words that leave are the words that entered: none lost, invented, altered or moved.
    - If a word is inside, it is offered, or an earlier word is.
    """

    DEPTH = 3

    def __init__(self, unit):
        self.dut = unit(ResultQueue)(8, self.DEPTH)

    def elaborate(self, platform):
        m = Module()
        queue, depth = self.dut, self.DEPTH
        m.submodules.dut = dut = Opened(queue)
        m.submodules.board = board = Scoreboard(8, 3)
        # The row of the watched word, if it is in the memory: `place` rows after the next row to be
        # read.
        place, row = Signal(3), Signal(range(depth))
        stored = dut.memory(m, "rows", row)
        rows = dut.submodules.rows
        write, fetched = rows.write_ports[0], rows.read_ports[0].addr
        held, holds, kept = map(dut.signal, ("held", "holds", "kept"))
        free(m, queue.put, queue.word, queue.words.ready)
        m.d.comb += [
            Assume(~queue.put | (board.inside < depth)),
            board.put.eq(queue.put),
            board.put_word.eq(queue.word),
            board.take.eq(queue.words.valid & queue.words.ready),
            board.take_word.eq(queue.words.payload),
            place.eq(board.watched - board.taken),
            row.eq((fetched + place - 1) % depth),
            Assert(board.inside == queue.words.valid + held + kept),
            Assert((board.inside == 0) | queue.words.valid),
            Cover((board.inside == depth) & (held == depth - 1) & (board.taken == 5)),
        ]

        # Invariants of the words inside, in the order of age, for the induction.
        m.d.comb += [
            Assert(board.inside <= depth),
            Assert(holds == (held != 0)),
            Assert((fetched < depth) & (write.addr < depth)),
            Assert(write.addr == (fetched + held) % depth),
        ]
        with m.If(place < board.inside):
            with m.If(place == 0):
                m.d.comb += Assert(queue.words.payload == board.value)
            with m.Elif(place <= held):
                m.d.comb += Assert(stored == board.value)
            with m.Else():
                # In the register before the memory.
                m.d.comb += Assert(write.data == board.value)
        return m


RESULT_QUEUE = Proof(
    claim=Queue,
    depth=10,
    reached=16,
    induction=2,
    faults={
        "the memory is passed by": (
            ResultQueue,
            ("Mux(holds, read.data, Mux(kept, late, self.word))", "Mux(kept, late, self.word)"),
        ),
        "a word is not kept behind those in the memory": (
            ResultQueue,
            ("self.put & (kept | holds | ~moves)", "self.put & (kept | ~moves)"),
        ),
        "a row more": (
            ResultQueue,
            ("Mux(leaves, held > 1, holds)", "Mux(leaves, held > 2, holds)"),
        ),
    },
)


class Ring(Elaboratable):
    """Proved for all time, by induction, for a ring of 4 rows of 8 bits.

    Assumed of the writer: it does not write a row that is committed but not yet fetched, and
    ``committed`` moves forward in each cycle, by any number of rows up to the size of the ring. The
    reader is free.

    - The transferred words are the rows in order, each as last written before it was committed:
      none is lost, repeated or invented.
    - At most two rows are fetched but not transferred.
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

        # The watched row: its latest contents, and its contents when it was fetched.
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

        # A row only waits for a word that is not taken.
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


RING = Proof(
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


PROOFS = {
    "skid": SKID,
    "stream_register": STREAM_REGISTER,
    "result_queue": RESULT_QUEUE,
    "ring": RING,
}
