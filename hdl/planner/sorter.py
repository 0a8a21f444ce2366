"""Sorter: the members of a population in the order of their keys.

The cells are a row of registers, from the entrance to the exit. A new member is compared with all
of them at once; those that are not above it move on by a cell, and it takes the place they leave.
An empty cell has the lowest of all keys. So after as many members as there are cells the least key
is next to the exit. Then the row moves on as a whole: the best member leaves first, and can be read
while the others are still inside.

A first population has more members than cells, and the worst must leave. Its keys are inverted on
their way in and out: the greatest key is next to the exit, and each further member pushes one out.
"""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.primitives.arguments import check_integer


__all__ = ["Sorter"]


class Sorter(wiring.Component):
    """Sorts members by their keys, one per cycle; of equals, the earlier stays first.

    Without ``keeps_best``, ``capacity`` members enter and leave from the best to the worst. Of
    equal keys, those that are not ``late`` come first, even if they enter after others that are.

    With ``keeps_best``, ``capacity`` members or more enter. From the first one too many on, the
    worst leaves for each, a new one behind its equals; in the end the others leave from the worst
    to the best. ``keeps_best`` changes only while the sorter is empty, and ``late`` is 0 with it.

    A member is compared in the cycle after it is taken.

    Parameters
    ----------
    capacity : int
        Cells, 2 or more.
    key_bits : int
        Width of a key, 1 or more.
    tag_bits : int
        Width of what goes with a key, 1 or more.

    Members
    -------
    keeps_best : In(1)
    members : In(stream.Signature(member_layout))
        ``key``, ``late`` and ``tag``. Ready while ``drain`` is low.
    full : Out(1)
        ``capacity`` members are inside.
    drain : In(1)
        Let a member leave. From ``full`` on, ``capacity`` cycles of it empty the sorter; no member
        enters before the last of them, or in the cycle before the first.
    left : Out(left_layout)
        ``valid``: a member left in the cycle before. ``key`` and ``tag`` are its own.

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    def __init__(self, capacity, key_bits, tag_bits):
        check_integer("Capacity", capacity, 2)
        check_integer("Key width", key_bits, 1)
        check_integer("Tag width", tag_bits, 1)

        self.capacity = capacity
        self.key_bits = key_bits
        self.tag_bits = tag_bits
        self.member_layout = data.StructLayout({"key": key_bits, "late": 1, "tag": tag_bits})
        self.left_layout = data.StructLayout({"valid": 1, "key": key_bits, "tag": tag_bits})
        self.cell_layout = data.StructLayout({"late": 1, "key": key_bits, "tag": tag_bits})
        super().__init__(
            {
                "keeps_best": In(1),
                "members": In(stream.Signature(self.member_layout)),
                "full": Out(1),
                "drain": In(1),
                "left": Out(self.left_layout),
            }
        )

    def elaborate(self, platform):
        m = Module()

        # `late` is the lowest bit of the order. With `keeps_best` a new member, which has 0 there,
        # is lower than its equals, which got a 1 when they took their places.
        cell_layout = self.cell_layout
        order_bits = 1 + self.key_bits
        entering = Signal(cell_layout)
        enters = Signal()
        inverted = self.keeps_best.replicate(self.key_bits)
        member = self.members.p
        m.d.comb += self.members.ready.eq(~self.drain)
        m.d.sync += [enters.eq(self.members.valid & ~self.drain), entering.eq(0)]
        with m.If(self.members.valid & ~self.drain):
            m.d.sync += [
                entering.late.eq(member.late),
                entering.key.eq(member.key ^ inverted),
                entering.tag.eq(member.tag),
            ]
        placed = Signal(cell_layout)
        m.d.comb += [placed.eq(entering), placed.late.eq(entering.late | self.keeps_best & enters)]

        cells = [Signal(cell_layout, name=f"cell_{i}") for i in range(self.capacity)]
        moves = Signal(self.capacity)
        for i, cell in enumerate(cells):
            below = cell.as_value()[:order_bits] <= entering.as_value()[:order_bits]
            m.d.comb += moves[i].eq(self.drain | (enters & below))
            with m.If(moves[i]):
                m.d.sync += cell.eq(Mux(moves[i - 1], cells[i - 1], placed) if i else placed)

        # Members inside.
        count = Signal(range(self.capacity + 1))
        with m.If(self.drain):
            m.d.sync += [count.eq(count - 1), self.full.eq(0)]
        with m.Elif(enters & ~self.full):
            m.d.sync += [count.eq(count + 1), self.full.eq(count == self.capacity - 1)]

        leaving = Mux(moves[-1], cells[-1], entering)
        held = Signal(cell_layout, reset_less=True)
        m.d.sync += [self.left.valid.eq(self.drain | (enters & self.full)), held.eq(leaving)]
        m.d.comb += [self.left.key.eq(held.key ^ inverted), self.left.tag.eq(held.tag)]

        return m
