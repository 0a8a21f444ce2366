"""The queue of results lets every word out, once and in order."""

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover

from pathgene.hdl.primitives.buffers import ResultQueue
from tests.formal.parts import Opened, Scoreboard, free
from tools.formal import Proof


class Queue(Elaboratable):
    """Proved for all time, by induction, for a queue of 3 words of 8 bits; the sink is free.

    Assumed of the source: it puts no word in where 3 are inside.

    - The words that leave are the words that entered: none lost, invented, altered or moved.
    - A word that is inside is offered, or one before it is.
    """

    DEPTH = 3

    def __init__(self, unit):
        self.dut = unit(ResultQueue)(8, self.DEPTH)

    def elaborate(self, platform):
        m = Module()
        queue, depth = self.dut, self.DEPTH
        m.submodules.dut = dut = Opened(queue)
        m.submodules.board = board = Scoreboard(8, 3)
        # The row of the watched word, if it is in the memory: `place` rows after the next one read.
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


PROOF = Proof(
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
