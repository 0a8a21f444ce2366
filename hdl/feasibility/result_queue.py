"""Queue of results, with registers at its output."""

from amaranth import *
from amaranth.lib import memory, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Count, Given, Unit


__all__ = ["ResultQueue"]


class ResultQueue(Unit):
    """First-in, first-out queue; a word is offered in the cycle after it is put in.

    ``valid`` and ``payload`` are registers. An incoming word goes to two registers, not to the
    memory: a word that cannot be offered at once enters the memory a cycle later. This leaves
    timing slack for a long path into ``word`` and another out of ``words``.

    Members
    -------
    put : In(1)
        Put ``word`` in, if there is room.
    word : In(shape)
    words : Out(stream.Signature(shape))
    """

    shape: Given("ShapeLike", "Shape of a word.")
    depth: Count(1, text="Words that fit; a further word is lost.")

    def interface(self):
        return {"put": In(1), "word": In(self.shape), "words": Out(stream.Signature(self.shape))}

    def elaborate(self, platform):
        m = Module()

        words = self.words
        moves = Signal()
        payload = Signal(self.shape, reset_less=True)
        m.d.comb += [moves.eq(~words.valid | words.ready), words.payload.eq(payload)]
        if self.depth == 1:
            with m.If(moves):
                m.d.sync += [words.valid.eq(self.put), payload.eq(self.word)]
            return m

        # From the oldest: at the output, in the memory, in the register before the memory.
        m.submodules.rows = rows = memory.Memory(shape=self.shape, depth=self.depth, init=[])
        write, read = rows.write_port(), rows.read_port(domain="comb")
        late, kept = Signal(self.shape, reset_less=True), Signal()
        held = Signal(range(self.depth + 1))  # In the memory.
        holds = Signal()  # Any.
        stays, leaves = Signal(), Signal()
        m.d.comb += [
            write.data.eq(late),
            stays.eq(kept & (holds | ~moves)),
            write.en.eq(stays),
            leaves.eq(holds & moves),
        ]
        m.d.sync += [
            late.eq(self.word),
            kept.eq(self.put & (kept | holds | ~moves)),
            held.eq(held + stays - leaves),
            holds.eq(stays | Mux(leaves, held > 1, holds)),
        ]
        for port, moved in ((write, stays), (read, leaves)):
            with m.If(moved):
                m.d.sync += port.addr.eq(Mux(port.addr == self.depth - 1, 0, port.addr + 1))
        with m.If(moves):
            m.d.sync += [
                words.valid.eq(holds | kept | self.put),
                payload.eq(Mux(holds, read.data, Mux(kept, late, self.word))),
            ]

        return m
