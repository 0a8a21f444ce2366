"""Buffers of streams: a word, a register, queues."""

from amaranth import *
from amaranth.lib import memory, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.cells import cells_of
from pathgene.hdl.primitives.unit import Count, Given, Unit


__all__ = ["MemoryQueue", "ResultQueue", "SkidBuffer", "StreamRegister"]


class SkidBuffer(Unit):
    """Breaks a chain of ``ready`` signals by storing one word that it cannot pass on.

    An empty buffer passes words through in the same cycle, with ``ready`` high regardless of
    ``passed.ready``; it neither costs a cycle nor adds pauses to a stream.

    Members
    -------
    words : In(stream.Signature(shape))
        ``ready`` is a register.
    passed : Out(stream.Signature(shape))
        The same words. ``valid`` and ``payload`` come from ``words`` through one multiplexer.
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


class StreamRegister(Unit):
    """Puts registers in the path of ``valid`` and ``payload``; ``ready`` passes through.

    A word is offered one cycle after it is taken; no pauses are added to the stream.

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


class ResultQueue(Unit):
    """FIFO queue; a word is offered in the cycle after it is put in.

    ``valid`` and ``payload`` are registers. An incoming word goes to two registers instead of the
    memory; a word that cannot be offered immediately enters the memory one cycle later. This leaves
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

        # Words from the oldest: at the output, in the memory, in the register before the memory.
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


#: Maximum depth of a single row of LUTs.
_SHALLOW = 16


class MemoryQueue(Unit):
    """FIFO queue; a word is offered in the cycle after it is put in.

    On a target the memory consists of LUTs, unless it is deep and the platform prefers block RAMs.

    Members
    -------
    clear : In(1)
        Empty the queue. Overrides the rest.
    put : In(1)
        Put ``word`` in; not while ``depth`` words are inside.
    word : In(shape)
    words : Out(stream.Signature(shape))
    """

    shape: Given("ShapeLike", "Shape of a word.")
    depth: Count(1, text="Words that fit.")

    def interface(self):
        return {
            "clear": In(1),
            "put": In(1),
            "word": In(self.shape),
            "words": Out(stream.Signature(self.shape)),
        }

    def elaborate(self, platform):
        m = Module()

        # Only a deep queue has more words than fit into one row of LUTs.
        style = cells_of(platform).ram_style if self.depth > _SHALLOW else "distributed"
        m.submodules.rows = rows = memory.Memory(
            shape=self.shape, depth=self.depth, init=[], attrs={"ram_style": style}
        )
        write = rows.write_port()
        takes = self.words.valid & self.words.ready
        following = []
        for name, moved in (("put", self.put), ("taken", takes)):
            at, to = (Signal(range(self.depth), name=f"{each}_{name}") for each in ("at", "to"))
            m.d.comb += to.eq(Mux(moved, Mux(at == self.depth - 1, 0, at + 1), at))
            m.d.sync += at.eq(to)
            with m.If(self.clear):
                m.d.sync += at.eq(0)
            following.append((at, to))
        m.d.comb += [
            write.addr.eq(following[0][0]),
            write.data.eq(self.word),
            write.en.eq(self.put),
        ]
        # The word is the same either way: LUTs are read after the register of the address.
        if style == "block":
            read = rows.read_port(transparent_for=(write,))
            m.d.comb += read.addr.eq(following[1][1])
        else:
            read = rows.read_port(domain="comb")
            m.d.comb += read.addr.eq(following[1][0])
        m.d.comb += self.words.payload.eq(read.data)
        # A register, because `ready` often arrives late.
        left, is_single = Signal(range(self.depth + 1)), Signal()
        with m.If(self.put & ~takes):
            m.d.sync += [left.eq(left + 1), is_single.eq(left == 0), self.words.valid.eq(1)]
        with m.Elif(takes & ~self.put):
            m.d.sync += [
                left.eq(left - 1),
                is_single.eq(left == 2),
                self.words.valid.eq(~is_single),
            ]
        with m.If(self.clear):
            m.d.sync += [left.eq(0), self.words.valid.eq(0)]

        return m
