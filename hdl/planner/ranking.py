"""Ranking: the members of each island's population by their ranks."""

from amaranth import *
from amaranth.lib import data, memory, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from hdl.planner.population_layouts import KEY_BITS, member_layout, path_layout
from hdl.planner.sorter import Sorter
from hdl.primitives.arguments import check_integer, check_power_of_two


__all__ = ["Ranking"]


class Ranking(wiring.Component):
    """Sorts the members of a population, and holds those of every island by their ranks.

    The sorter receives the next population of an island while the present one is read from a
    memory, from which its parents are drawn. ``store`` moves the next one there and takes
    ``population + 2`` cycles: ``busy``. Members enter again after ``population`` of them.

    Parameters
    ----------
    population : int
        Members of an island: a power of two, 2 to 256.
    islands : int
        A power of two, 1 to 16.
    slot_bits, length_bits : int
        Widths of a slot and of a length, 1 or more.

    Members
    -------
    keeps_best : In(1)
        The members are those of a first population, of which the best stay: see
        :class:`hdl.planner.sorter.Sorter`. Changes only while the sorter is empty and not ``busy``.
    members : In(stream.Signature(sorted_layout))
        ``member``, and ``late``: it is behind those of its key that are not.
        Not ready in the ``population`` cycles after ``store``.
    store : In(1)
        Pulse: move the population to the memory. Only after its last member is taken, of
        ``population`` or more.
    island : In(range(islands))
        Island that it becomes, with ``store``.
    busy : Out(1)
        It is being moved.
    dropped : Out(dropped_layout)
        ``valid``: a member too many has left the sorter, and ``slot`` is free.
    read : In(read_layout)
        ``island`` and ``rank``, while not ``busy``.
    member : Out(member_layout)
        The member that was at ``read`` in the cycle before.

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    def __init__(self, population, islands, slot_bits, length_bits):
        check_power_of_two("Population", population, 2, 256)
        check_power_of_two("Islands", islands, 1, 16)
        check_integer("Slot width", slot_bits, 1)
        check_integer("Length width", length_bits, 1)

        self.population = population
        self.islands = islands
        self.slot_bits = slot_bits
        self.length_bits = length_bits
        self.member_layout = member_layout(slot_bits, length_bits)
        self.sorted_layout = data.StructLayout({"member": self.member_layout, "late": 1})
        self.read_layout = data.StructLayout({"island": range(islands), "rank": range(population)})
        self.dropped_layout = data.StructLayout({"valid": 1, "slot": slot_bits})
        super().__init__(
            {
                "keeps_best": In(1),
                "members": In(stream.Signature(self.sorted_layout)),
                "store": In(1),
                "island": In(range(islands)),
                "busy": Out(1),
                "dropped": Out(self.dropped_layout),
                "read": In(self.read_layout),
                "member": Out(self.member_layout),
            }
        )

    def elaborate(self, platform):
        m = Module()

        tag_layout = path_layout(self.slot_bits, self.length_bits)
        m.submodules.sorter = sorter = Sorter(self.population, KEY_BITS, tag_layout.size)
        tag = tag_layout(sorter.left.tag)
        member = self.members.p.member
        # A member leaves the sorter two cycles after it is asked for, and is written.
        storing = Signal()
        leaves = Signal()
        writes = Signal()
        m.d.comb += [
            sorter.keeps_best.eq(self.keeps_best),
            sorter.members.valid.eq(self.members.valid),
            sorter.members.p.key.eq(member.key),
            sorter.members.p.late.eq(self.members.p.late),
            sorter.members.p.tag.eq(Cat(member.slot, member.length)),
            self.members.ready.eq(sorter.members.ready),
            sorter.drain.eq(storing),
            self.dropped.valid.eq(sorter.left.valid & ~writes),
            self.dropped.slot.eq(tag.slot),
        ]

        rank_bits = exact_log2(self.population)
        island = Signal(range(self.islands), reset_less=True)
        rank = Signal(rank_bits)
        m.d.comb += self.busy.eq(storing | leaves | writes)
        m.d.sync += [leaves.eq(storing), writes.eq(leaves), rank.eq(rank + writes)]
        drained = Signal(rank_bits)
        with m.If(storing):
            m.d.sync += [drained.eq(drained + 1), storing.eq(~drained.all())]
        with m.If(self.store):
            m.d.sync += [storing.eq(1), island.eq(self.island)]

        # In LUTs on a target. The register is in front of them: ranks to be read come late.
        m.submodules.rows = rows = memory.Memory(
            shape=self.member_layout, depth=self.islands * self.population, init=[]
        )
        write, read = rows.write_port(), rows.read_port(domain="comb")
        m.d.comb += [
            write.en.eq(writes),
            write.addr.eq(Cat(rank ^ self.keeps_best.replicate(rank_bits), island)),
            write.data.key.eq(sorter.left.key),
            write.data.slot.eq(tag.slot),
            write.data.length.eq(tag.length),
            self.member.eq(read.data),
        ]
        m.d.sync += read.addr.eq(Cat(self.read.rank, self.read.island))

        return m
