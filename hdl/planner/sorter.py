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
        Let a member leave. Once ``full``, ``capacity`` cycles of it empty the sorter, and no member
        enters before the last of them.
    left : Out(left_layout)
        ``valid``: a member has left, 2 cycles after that of ``drain`` or after the one too many was
        taken. ``key`` and ``tag`` are its own.

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
        self.cell_layout = data.StructLayout(
            {"late": 1, "key": key_bits, "there": 1, "tag": tag_bits}
        )
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

        # The order, from the lowest bit: `late`, key, and whether there is a member at all. With
        # `keeps_best` a new member has 0 in `late`, below its equals, which got a 1 in their cells.
        order_bits = 2 + self.key_bits
        entering = Signal(self.cell_layout)
        drains = Signal()
        inverted = self.keeps_best.replicate(self.key_bits)
        member = self.members.p
        m.d.comb += self.members.ready.eq(~self.drain)
        m.d.sync += [drains.eq(self.drain), entering.eq(0)]
        with m.If(self.drain):
            # Above all, so that every cell moves on. It is not placed.
            m.d.sync += entering.eq((1 << order_bits) - 1)
        with m.Elif(self.members.valid):
            m.d.sync += [
                entering.late.eq(member.late),
                entering.key.eq(member.key ^ inverted),
                entering.there.eq(1),
                entering.tag.eq(member.tag),
            ]
        enters = Signal()
        placed = Signal(self.cell_layout)
        m.d.comb += [
            enters.eq(entering.there & ~drains),
            placed.eq(Mux(drains, 0, entering)),
            placed.late.eq(enters & (entering.late | self.keeps_best)),
        ]

        # Where nothing enters, empty cells move on alone: nothing changes.
        cells = [Signal(self.cell_layout, name=f"cell_{i}") for i in range(self.capacity)]
        moves = Signal(self.capacity)
        new = entering.as_value()[:order_bits]
        for i, cell in enumerate(cells):
            # Not `<=`, which synthesis makes of two comparisons.
            m.d.comb += moves[i].eq(~(new < cell.as_value()[:order_bits]))
            with m.If(moves[i]):
                m.d.sync += cell.eq(Mux(moves[i - 1], cells[i - 1], placed) if i else placed)

        # Members inside.
        count = Signal(range(self.capacity + 1))
        with m.If(drains):
            m.d.sync += [count.eq(count - 1), self.full.eq(0)]
        with m.Elif(enters & ~self.full):
            m.d.sync += [count.eq(count + 1), self.full.eq(count == self.capacity - 1)]

        leaving = Signal(self.cell_layout)
        held = Signal(self.cell_layout, reset_less=True)
        m.d.comb += [
            leaving.eq(Mux(moves[-1], cells[-1], entering)),
            self.left.key.eq(held.key ^ inverted),
            self.left.tag.eq(held.tag),
        ]
        m.d.sync += [self.left.valid.eq(leaving.there), held.eq(leaving)]

        return m
