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
        enters, count = dut.signal("enters"), dut.signal("count")
        keeps_best, members = sorter.keeps_best, sorter.members
        free(m, members.valid, members.payload, sorter.drain)

        # `keeps_best` is chosen anew where nothing is inside.
        choice = Signal()
        mode = Signal()
        free(m, choice)
        draining = Signal()
        earlier = Signal()
        empty = (count == 0) & ~enters
        m.d.comb += [
            mode.eq(Mux(empty & ~sorter.left.valid, choice, earlier)),
            keeps_best.eq(mode),
            Assume(~members.valid | ~members.p.late | ~mode),
            Assume(~sorter.drain | ((sorter.full | draining) & ~enters)),
            Assume(~members.valid | ~(draining | sorter.drain)),
        ]
        m.d.sync += [earlier.eq(mode), draining.eq(Mux(sorter.drain, count != 1, draining))]
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
        with m.If(draining):
            m.d.comb += inside.eq(Cat(i + count >= capacity for i in range(capacity)))
        with m.Else():
            m.d.comb += inside.eq(Cat(i < count for i in range(capacity)))
        m.d.comb += [
            Assert(count <= capacity),
            Assert(sorter.full == (count == capacity)),
            Assert(~draining | ((count != 0) & (count != capacity) & ~enters)),
            Assert(~enters | (entering.tag + 1 == number)),
            Assert(~enters | ~mode | ~entering.late),
            Assert(enters | (Value.cast(entering) == 0)),
            Assert(~sorter.full | ~draining),
        ]
        order = 1 + self.KEY_BITS
        for i, cell in enumerate(cells):
            newest = Mux(enters, entering.tag, number)
            m.d.comb += [
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
    depth=9,
    induction=2,
    faults={
        "a member overtakes its equals": (
            Sorter,
            ("as_value()[:order_bits] <= entering", "as_value()[:order_bits] < entering"),
        ),
        "a new member does not give way to its equals": (
            Sorter,
            ("entering.late | self.keeps_best & enters", "entering.late"),
        ),
        "what is pushed out is lost": (
            Sorter,
            ("self.drain | (enters & self.full)", "self.drain"),
        ),
        "a member that is worse than all is taken for another": (
            Sorter,
            ("Mux(moves[-1], cells[-1], entering)", "cells[-1]"),
        ),
    },
)
