"""Queue in a memory."""

from amaranth import *
from amaranth.lib import memory, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.cells import cells_of
from pathgene.hdl.primitives.unit import Count, Given, Unit


__all__ = ["MemoryQueue"]

#: Maximum depth of one row of LUTs.
_SHALLOW = 16


class MemoryQueue(Unit):
    """First-in, first-out queue; a word is offered in the cycle after it is put in.

    On a target the memory consists of LUTs, unless it is deep and the platform prefers block RAMs.

    Members
    -------
    clear : In(1)
        Empty the queue. Overrides the rest.
    put : In(1)
        Put ``word`` in; not where ``depth`` words are inside.
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

        # Only a deep queue has more words than one row of LUTs holds.
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
        # The same word, either way: LUTs are read after the register of the address.
        if style == "block":
            read = rows.read_port(transparent_for=(write,))
            m.d.comb += read.addr.eq(following[1][1])
        else:
            read = rows.read_port(domain="comb")
            m.d.comb += read.addr.eq(following[1][0])
        m.d.comb += self.words.payload.eq(read.data)
        # A register, since `ready` often arrives late.
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
