"""Ranking: the members of each island's population by their ranks."""

from amaranth import *
from amaranth.lib import data, memory, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.population_layouts import KEY_BITS, member_layout, path_layout
from pathgene.hdl.planner.sorter import Sorter
from pathgene.hdl.primitives.cells import cells_of
from pathgene.hdl.primitives.unit import PowerOfTwo, Unit, Width
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass


__all__ = ["Ranking"]


class Ranking(Unit):
    """Sorts the members of a population, and holds the members of every island by rank.

    The sorter receives the next population of an island while the present one is read from a
    memory, from which its parents are drawn. ``store`` moves the next one there. That takes
    ``population`` cycles, from the cycle after ``store`` or from the cycle in which the last member
    is inserted, if this is later. Then members enter again, and ``busy`` falls.

    Members
    -------
    members : In(stream.Signature(sorted_layout))
        ``member``, and ``late``: it ranks after members with the same key that are not late. Not
        ready while ``busy``, and after a member as in :class:`pathgene.hdl.planner.sorter.Sorter`.
    store : In(1)
        Pulse: move the population to the memory. In a cycle after its last member is taken, of
        ``population`` or more; the best of them are the population.
    island : In(range(islands))
        Island of the population, with ``store``.
    busy : Out(1)
        The population is being moved: starts in the cycle after ``store``.
    dropped : Out(dropped_layout)
        ``valid``: a member too many has left the sorter, and ``slot`` is free: 2 cycles after one
        was taken.
    read : In(read_layout)
        ``island`` and ``rank``, while not ``busy``.
    member : Out(member_layout)
        The member that was at ``read`` in the previous cycle.
    feasible : Out(1)
        The best path of the population that was moved last is feasible. While not ``busy``.
    """

    population: PowerOfTwo(2, 256, "Members of an island.")
    islands: PowerOfTwo(1, 16)
    slot_bits: Width(1)
    length_bits: Width(1)

    def interface(self):
        self.member_layout = member_layout(self.slot_bits, self.length_bits)
        self.sorted_layout = data.StructLayout({"member": self.member_layout, "late": 1})
        self.read_layout = data.StructLayout(
            {"island": range(self.islands), "rank": range(self.population)}
        )
        self.dropped_layout = data.StructLayout({"valid": 1, "slot": self.slot_bits})
        return {
            "members": In(stream.Signature(self.sorted_layout)),
            "store": In(1),
            "island": In(range(self.islands)),
            "busy": Out(1),
            "dropped": Out(self.dropped_layout),
            "read": In(self.read_layout),
            "member": Out(self.member_layout),
            "feasible": Out(1),
        }

    def elaborate(self, platform):
        m = Module()

        tag_layout = path_layout(self.slot_bits, self.length_bits)
        m.submodules.sorter = sorter = Sorter(self.population, KEY_BITS, tag_layout.size)
        tag, dropped = tag_layout(sorter.left.tag), tag_layout(sorter.dropped.tag)
        member = self.members.p.member
        island = Signal(range(self.islands), reset_less=True)
        m.d.comb += [
            sorter.members.valid.eq(self.members.valid),
            sorter.members.p.key.eq(member.key),
            sorter.members.p.late.eq(self.members.p.late),
            sorter.members.p.tag.eq(Cat(member.slot, member.length)),
            self.members.ready.eq(sorter.members.ready),
            sorter.empty.eq(self.store),
            self.busy.eq(sorter.emptying),
            self.dropped.valid.eq(sorter.dropped.valid),
            self.dropped.slot.eq(dropped.slot),
        ]
        with m.If(self.store):
            m.d.sync += island.eq(self.island)
        with m.If(sorter.left.valid & (sorter.left.rank == 0)):
            m.d.sync += self.feasible.eq(sorter.left.key[VALUE_BITS:] == PathClass.FEASIBLE)

        m.submodules.rows = rows = memory.Memory(
            shape=self.member_layout,
            depth=self.islands * self.population,
            init=[],
            attrs={"ram_style": cells_of(platform).ram_style},
        )
        write = rows.write_port()
        # With `transparent_for` the register is in front of LUTs: ranks to be read come late.
        read = rows.read_port(transparent_for=(write,))
        m.d.comb += [
            write.en.eq(sorter.left.valid),
            write.addr.eq(Cat(sorter.left.rank, island)),
            write.data.key.eq(sorter.left.key),
            write.data.slot.eq(tag.slot),
            write.data.length.eq(tag.length),
            read.addr.eq(Cat(self.read.rank, self.read.island)),
            self.member.eq(read.data),
        ]

        return m
