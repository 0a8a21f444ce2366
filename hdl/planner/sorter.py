"""Sorter of the members of a population by their keys."""

from amaranth import *
from amaranth.lib import data, memory, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["Sorter"]


class Sorter(Unit):
    """Sorts members by their keys by insertion, and keeps the best.

    Members are stored in a memory by rank, with the best in row 0. A new member is first compared
    with the worst. It passes the members below it, one row per cycle, and each of them moves down
    by a row. If it passes n members, the next member is taken at least 2 + n cycles after it.

    Among equal keys, members that are not ``late`` come first; if that is equal too, the earlier
    member comes first. Once ``capacity`` members are inside, each new one drops the worst member,
    or is dropped itself if it passes none. A dropped worst member counts as passed.

    Members
    -------
    members : In(stream.Signature(member_layout))
        ``key``, ``late`` and ``tag``. Ready unless a member is being inserted, or ``emptying``.
    empty : In(1)
        Pulse: let all members leave. In a cycle after the last of ``capacity`` or more members was
        taken.
    emptying : Out(1)
        High from the cycle after ``empty`` until the last row has been read: ``capacity`` cycles,
        preceded by the cycles in which the last member is inserted.
    left : Out(left_layout)
        ``valid``: a member has left, from the best to the worst, in the ``capacity`` cycles that
        end with the cycle after ``emptying``. ``rank``, ``key`` and ``tag`` belong to it.
    dropped : Out(dropped_layout)
        ``valid``: a surplus member has left, 2 cycles after a member was taken. ``tag`` belongs to
        it.
    """

    capacity: Count(2, text="Members inside.")
    key_bits: Width(1)
    tag_bits: Width(1, text="The tag goes with the key.")

    def interface(self):
        self.member_layout = data.StructLayout(
            {"late": 1, "key": self.key_bits, "tag": self.tag_bits}
        )
        self.left_layout = data.StructLayout(
            {"valid": 1, "rank": range(self.capacity), "key": self.key_bits, "tag": self.tag_bits}
        )
        self.dropped_layout = data.StructLayout({"valid": 1, "tag": self.tag_bits})
        return {
            "members": In(stream.Signature(self.member_layout)),
            "empty": In(1),
            "emptying": Out(1),
            "left": Out(self.left_layout),
            "dropped": Out(self.dropped_layout),
        }

    def elaborate(self, platform):
        m = Module()
        last = self.capacity - 1

        # LUTs on a target, with the register after them, in front of the comparison.
        m.submodules.rows = rows = memory.Memory(
            shape=self.member_layout, depth=self.capacity, init=[]
        )
        write, read = rows.write_port(), rows.read_port(domain="comb")
        # The row of the worst member, the row being read, and the row in the register; -1 if there
        # is none.
        worst, row, at = (
            Signal(range(-1, self.capacity), init=-1, name=name) for name in ("worst", "row", "at")
        )
        held = Signal(self.member_layout, reset_less=True)
        entering = Signal(self.member_layout, reset_less=True)
        inserting = Signal()
        passes = Signal()
        # The sort order, from the lowest bit: `late`, then the key.
        order_bits = 1 + self.key_bits
        new, old = (each.as_value()[:order_bits] for each in (entering, held))
        m.d.comb += [
            self.members.ready.eq(~inserting & ~self.emptying),
            passes.eq((at >= 0) & (new < old)),
            read.addr.eq(row),
            write.en.eq(inserting & (at != last)),
            write.addr.eq(at + 1),
            write.data.eq(Mux(passes, held, entering)),
            self.left.rank.eq(at),
            self.left.key.eq(held.key),
            self.left.tag.eq(held.tag),
        ]
        m.d.sync += [
            at.eq(row),
            held.eq(read.data),
            self.left.valid.eq(self.emptying & ~inserting),
            self.dropped.valid.eq(inserting & (at == last)),
            self.dropped.tag.eq(Mux(passes, held.tag, entering.tag)),
        ]

        # `valid` arrives late.
        with m.If(self.members.ready):
            m.d.sync += entering.eq(self.members.p)
        # A member that stops goes to the row after the compared one; the worst is read next.
        stopped = Signal(worst.shape())
        m.d.comb += stopped.eq(Mux(worst == last, last, worst + 1))
        with m.If(self.empty):
            m.d.sync += self.emptying.eq(1)
        with m.If(inserting):
            m.d.sync += row.eq(row - 1)
            with m.If(~passes):
                m.d.sync += [
                    inserting.eq(0),
                    worst.eq(stopped),
                    row.eq(Mux(self.empty | self.emptying, 0, stopped)),
                ]
        with m.Elif(self.emptying):
            m.d.sync += row.eq(row + 1)
            with m.If(row == last):
                m.d.sync += [self.emptying.eq(0), worst.eq(-1), row.eq(-1)]
        with m.Elif(self.empty):
            m.d.sync += row.eq(0)
        with m.Elif(self.members.valid):
            m.d.sync += [inserting.eq(1), row.eq(row - 1)]

        return m
