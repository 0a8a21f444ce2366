"""The sorter keeps its members in order, and loses and invents none."""

import itertools

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover
from amaranth.lib import data

from hdl.planner.sorter import Sorter
from tests.formal.parts import Opened, any_constant, free
from tools.formal import Proof


class Sorted(Elaboratable):
    """Proved for all time, by induction, for 3 members of 2 bits of key; the source is free.

    Assumed of the user: members leave in a row of 3, once that many are inside, and none enters
    meanwhile; ``keeps_best`` changes only while the sorter is empty, and then no member is late.

    - The cells are in order: what leaves next is the least, or with ``keeps_best`` the greatest.
      Of equals that entered one after another, with numbers for tags, the earlier is better.
    - Any one member, watched by key and number, is inside as often as it entered and has not left.
    """

    CAPACITY, KEY_BITS, TAG_BITS = 3, 2, 3

    def __init__(self, unit):
        self.dut = unit(Sorter)(self.CAPACITY, self.KEY_BITS, self.TAG_BITS)

    def elaborate(self, platform):
        m = Module()
        sorter, capacity = self.dut, self.CAPACITY
        m.submodules.dut = dut = Opened(sorter)
        *cells, entering = (
            data.View(sorter.cell_layout, dut.signal(name))
            for name in (*(f"cell_{i}" for i in range(capacity)), "entering")
        )
        enters, drains, count = map(dut.signal, ("enters", "drains", "count"))
        keeps_best, members = sorter.keeps_best, sorter.members
        free(m, members.valid, members.payload, sorter.drain)

        # `keeps_best` is chosen anew where nothing is inside or has just left. Once the sorter is
        # full its members leave, in `asked` steps, of which `drains` is the last.
        choice = Signal()
        mode = Signal()
        earlier = Signal()
        asked = Signal(range(capacity))
        draining = Signal()
        m.d.comb += [
            mode.eq(Mux((count == 0) & ~enters & ~sorter.left.valid, choice, earlier)),
            keeps_best.eq(mode),
            draining.eq(asked != 0),
            Assume(~members.valid | ~members.p.late | ~mode),
            Assume(~sorter.drain | draining | (sorter.full & ~drains)),
            Assume(~members.valid | ~(draining | sorter.drain)),
        ]
        free(m, choice)
        m.d.sync += earlier.eq(mode)
        with m.If(sorter.drain):
            m.d.sync += asked.eq(Mux(asked == capacity - 1, 0, asked + 1))
        # Tags are numbers of the order of entrance, as far as they go.
        number = Signal(self.TAG_BITS)
        m.d.comb += [
            Assume(~members.valid | (members.p.tag == number)),
            Assume(~number.all()),
        ]
        with m.If(members.valid & members.ready):
            m.d.sync += number.eq(number + 1)

        # What is inside: from the entrance on while members enter, before the exit afterwards.
        inside = Signal(capacity)
        leaving = Signal()
        m.d.comb += leaving.eq((count != capacity) & (draining | drains))
        with m.If(leaving):
            m.d.comb += inside.eq(Cat(i + count >= capacity for i in range(capacity)))
        with m.Else():
            m.d.comb += inside.eq(Cat(i < count for i in range(capacity)))
        order = 2 + self.KEY_BITS
        m.d.comb += [
            Assert((count <= capacity) & (asked < capacity)),
            Assert(sorter.full == (count == capacity)),
            Assert(~draining | (count == capacity - asked + drains)),
            Assert(draining | ~drains | (count == 1)),
            Assert(~drains | Value.cast(entering)[:order].all()),
            Assert(~enters | (entering.tag + 1 == number)),
            Assert(~enters | ~mode | ~entering.late),
            Assert(enters | drains | (Value.cast(entering) == 0)),
            Assert(enters == (entering.there & ~drains)),
            Assert(~enters | ~draining),
        ]
        newest = Mux(enters, entering.tag, number)
        for i, cell in enumerate(cells):
            m.d.comb += [
                Assert(inside[i] == cell.there),
                Assert(inside[i] | (Value.cast(cell) == 0)),
                Assert(~inside[i] | (cell.tag < newest)),
                Assert(~inside[i] | ~mode | cell.late),
            ]
        for i, (cell, after) in enumerate(itertools.pairwise(cells)):
            place, place_after = (Value.cast(each)[:order] for each in (cell, after))
            with m.If(inside[i] & inside[i + 1]):
                m.d.comb += Assert(place >= place_after)
                with m.If(place == place_after):
                    m.d.comb += Assert(Mux(mode, cell.tag < after.tag, cell.tag > after.tag))

        # The watched member.
        key = any_constant(m, self.KEY_BITS, "watched_key")
        tag = any_constant(m, self.TAG_BITS, "watched_tag")
        stored = key ^ mode.replicate(self.KEY_BITS)
        entered = Signal(2)
        gone = Signal(2)
        present = Signal(range(capacity + 2))
        m.d.comb += present.eq(
            sum(
                (inside[i] & (cell.key == stored) & (cell.tag == tag))
                for i, cell in enumerate(cells)
            )
            + (enters & (entering.key == stored) & (entering.tag == tag))
        )
        comes = members.valid & members.ready & (members.p.key == key) & (members.p.tag == tag)
        goes = sorter.left.valid & (sorter.left.key == key) & (sorter.left.tag == tag)
        m.d.sync += [entered.eq(entered + comes), gone.eq(gone + goes)]
        m.d.comb += [
            Assert(entered == gone + present + goes),
            Assert(entered <= 1),
            Assert((entered == 0) | (tag < number)),
            Cover((gone == 1) & mode),
            Cover((gone == 1) & ~mode & (tag == 2)),
        ]
        return m


PROOF = Proof(
    claim=Sorted,
    depth=8,
    induction=2,
    faults={
        "a member overtakes its equals": (
            Sorter,
            ("~(new < cell.as_value()[:order_bits])", "cell.as_value()[:order_bits] < new"),
        ),
        "a new member does not give way to its equals": (
            Sorter,
            ("enters & (entering.late | self.keeps_best)", "enters & entering.late"),
        ),
        "what is pushed out is lost": (
            Sorter,
            ("self.left.valid.eq(leaving.there)", "self.left.valid.eq(drains)"),
        ),
        "what drives the members out takes a place": (
            Sorter,
            ("placed.eq(Mux(drains, 0, entering))", "placed.eq(entering)"),
        ),
        "a member that is worse than all is taken for another": (
            Sorter,
            ("Mux(moves[-1], cells[-1], entering)", "cells[-1]"),
        ),
    },
)
