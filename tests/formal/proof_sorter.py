"""The sorter keeps its members in order, drops the worst, and loses and invents none."""

import itertools

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover
from amaranth.lib import data

from pathgene.hdl.planner.sorter import Sorter
from tests.formal.parts import Opened, any_constant, free
from tools.formal import Proof


class Sorted(Elaboratable):
    """Proved for all time, by induction, for 3 members of 2 bits of key; the source is free.

    Assumed of the user: the sorter is only emptied after at least 3 members were taken, in a cycle
    after the last of them, and not again meanwhile.

    - The rows are in order, best first, even while they leave. With numbers as tags, the earlier of
      two equal members comes first.
    - An arbitrary member, watched by its number, is inside exactly if it entered and has not left,
      with its key. If it is dropped, no member inside is worse.
    """

    CAPACITY, KEY_BITS, TAG_BITS = 3, 2, 3

    def __init__(self, unit):
        self.dut = unit(Sorter)(self.CAPACITY, self.KEY_BITS, self.TAG_BITS)

    def elaborate(self, platform):
        m = Module()
        sorter, last = self.dut, self.CAPACITY - 1
        m.submodules.dut = dut = Opened(sorter)
        rows = [data.View(sorter.member_layout, dut.memory(m, "rows", i)) for i in range(last + 1)]
        held, entering = (
            data.View(sorter.member_layout, dut.signal(name)) for name in ("held", "entering")
        )
        worst, row, at, inserting = map(dut.signal, ("worst", "row", "at", "inserting"))
        members, left, dropped = sorter.members, sorter.left, sorter.dropped
        takes = members.valid & members.ready
        emptying = sorter.emptying & ~inserting
        free(m, members.valid, members.payload, sorter.empty)
        # Tags are numbers in order of entrance, up to their width.
        number = Signal(self.TAG_BITS)
        m.d.comb += [
            Assume(~sorter.empty | (~sorter.emptying & ~takes & (worst + inserting >= last))),
            Assume(~members.valid | (members.p.tag == number)),
            Assume(~number.all()),
        ]
        m.d.sync += number.eq(number + takes)

        # Rows of members inside: while one is inserted, the row after the one compared is void.
        inside = Signal(last + 1)
        for i in range(last + 1):
            with m.If(inserting):
                m.d.comb += inside[i].eq((i <= at) | ((i >= at + 2) & (i <= worst + 1)))
            with m.Elif(emptying):
                m.d.comb += inside[i].eq(i >= row)
            with m.Else():
                m.d.comb += inside[i].eq(i <= worst)
        there = [inside[i] | (left.valid & (at == i)) for i in range(last + 1)]

        # Invariants of rows and phases, for the induction.
        m.d.comb += [
            Assert((worst >= -1) & (worst <= last)),
            Assert(members.ready == ~(inserting | sorter.emptying)),
            Assert(~members.ready | (row == worst)),
            Assert(~inserting | ((at >= -1) & (at <= worst) & (row == at - 1))),
            Assert(~inserting | (entering.tag + 1 == number)),
            Assert(~sorter.emptying | (worst + inserting >= last)),
            Assert(~emptying | ((row >= 0) & (row <= last) & (worst == last))),
            Assert(~emptying | (left.valid == (row != 0))),
            Assert(~left.valid | (~inserting & (at == Mux(emptying, row - 1, last)))),
            Assert(~left.valid | emptying | (worst == -1)),
            Assert(~dropped.valid | ((worst == last) & ~left.valid)),
        ]
        newest = Mux(inserting, entering.tag, number)
        for i, each in enumerate(rows):
            with m.If(there[i]):
                m.d.comb += Assert(each.tag < newest)
            with m.If((at == i) & (inserting | left.valid)):
                m.d.comb += Assert(Value.cast(held) == Value.cast(each))
            with m.If(inserting & inside[i] & (i > at)):
                m.d.comb += Assert(self._order(entering) < self._order(each))

        for (i, before), (j, behind) in itertools.combinations(enumerate(rows), 2):
            with m.If(there[i] & there[j]):
                m.d.comb += Assert(self._order(before) <= self._order(behind))
                with m.If(self._order(before) == self._order(behind)):
                    m.d.comb += Assert(before.tag < behind.tag)

        # The watched member.
        tag = any_constant(m, self.TAG_BITS, "watched_tag")
        watched = Signal(sorter.member_layout)
        entered = Signal()
        gone = Signal(2)
        present = Signal(range(self.CAPACITY + 2))
        matches = [inside[i] & (each.tag == tag) for i, each in enumerate(rows)]
        matches.append(inserting & (entering.tag == tag))
        drops = dropped.valid & (dropped.tag == tag)
        leaves = left.valid & (left.tag == tag)
        m.d.comb += present.eq(sum(matches))
        with m.If(takes & (members.p.tag == tag)):
            m.d.sync += [entered.eq(1), watched.eq(members.p)]
        m.d.sync += gone.eq(gone + drops + leaves)
        m.d.comb += [
            Assert(entered == gone + present + drops + leaves),
            Assert(entered == (tag < number)),
            Assert(~leaves | (left.key == watched.key)),
            Cover((gone == 1) & (tag == 2) & ~sorter.emptying),
            Cover(drops & (tag == 0)),
            Cover(drops & (tag == 3)),
        ]
        for i, each in enumerate([*rows, entering]):
            with m.If(matches[i]):
                m.d.comb += Assert(Value.cast(each) == Value.cast(watched))
            with m.If(drops & (inside[i] if i <= last else inserting)):
                m.d.comb += Assert(self._order(each) <= self._order(watched))
        return m

    def _order(self, member):
        """Return the sorting key of a member."""
        return Cat(member.late, member.key)


PROOF = Proof(
    claim=Sorted,
    depth=13,
    induction=1,
    faults={
        "a member overtakes its equals": (Sorter, ("(new < old)", "(new <= old)")),
        "a late member does not give way to its equals": (
            Sorter,
            ("each.as_value()[:order_bits]", "each.as_value()[1:order_bits]"),
        ),
        "the worst stays where one is inserted in front of it": (
            Sorter,
            ("Mux(passes, held, entering)", "entering"),
        ),
        "a member in front of all goes on": (Sorter, ("(at >= 0) & (new < old)", "new < old")),
        "one too many drops the worst although it is worse": (
            Sorter,
            ("Mux(passes, held.tag, entering.tag)", "held.tag"),
        ),
        "members are let go while the last is inserted, from the wrong row on": (
            Sorter,
            ("Mux(self.empty | self.emptying, 0, stopped)", "Mux(self.emptying, 0, stopped)"),
        ),
        "a member is taken before those that leave are read": (
            Sorter,
            ("eq(~inserting & ~self.emptying)", "eq(~inserting)"),
        ),
    },
)
