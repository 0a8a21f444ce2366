"""Collector of an island's next population, from members that stay and children."""

from amaranth import *
from amaranth.lib import data, memory, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.layouts import KEY_BITS, member_layout, path_layout
from pathgene.hdl.planner.sorter import Sorter
from pathgene.hdl.primitives.cells import cells_of
from pathgene.hdl.primitives.unit import Count, PowerOfTwo, Unit, Width
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass


__all__ = ["Collector", "Ranking"]


class Ranking(Unit):
    """Sorts the members of a population, and stores the members of every island by rank.

    The sorter receives the next population of an island while the current one, from which parents
    are drawn, is read from a memory. ``store`` moves the next population there. That takes
    ``population`` cycles, from the cycle after ``store`` or from the cycle in which the last member
    is inserted, whichever is later. Then members can enter again, and ``busy`` falls.

    Members
    -------
    members : In(stream.Signature(sorted_layout))
        ``member``, and ``late``: it ranks after non-late members with the same key. Not ready while
        ``busy``, and after a member as in :class:`pathgene.hdl.planner.sorter.Sorter`.
    store : In(1)
        Pulse: move the population to the memory. In a cycle after its last member is taken; there
        are ``population`` or more, and the best of them form the population.
    island : In(range(islands))
        Island of the population, with ``store``.
    busy : Out(1)
        The population is being moved; rises in the cycle after ``store``.
    dropped : Out(dropped_layout)
        ``valid``: a surplus member has left the sorter, and ``slot`` is free, 2 cycles after a
        member was taken.
    read : In(read_layout)
        ``island`` and ``rank``, while not ``busy``.
    member : Out(member_layout)
        The member at the previous cycle's ``read``.
    feasible : Out(1)
        While not ``busy``: the best path of the last population moved is feasible.
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
        # With `transparent_for`, the register is in front of LUTs, because ranks to be read arrive
        # late.
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


class Collector(Unit):
    """Collects populations, sorts them, and stores the population of every island by rank.

    A generation is collected by a pass over the population, and from children that arrive before or
    after the pass. The pass goes through the ranks, best first: elites and survivors go to the
    sorter, and the slots of all other members become free. After the pass and the last child, the
    new population is complete and replaces the current one. Among equal keys, members that stay
    come first, by rank, then children in order of arrival.

    A member that passes n members in the sorter occupies the sorter until 2 + n cycles after it was
    taken: ``evaluated`` is not ready in between.

    With N members of a population, the pass begins 2 cycles after ``collect``, or when the sorter
    is free, if that is later. A rank takes one cycle, and a member that stays takes 1 + n more.
    ``evaluated`` is not ready from the second cycle after ``collect`` until the pass is over.
    ``stored`` is high in the first cycle in which the pass is over, the last child has arrived, and
    the sorter is free. ``evaluated`` is not ready from the last child until N + 1 cycles after
    ``stored``, when ``busy`` falls. The same holds for ``merge``, which passes over 2 N ranks.

    First populations also come from ``evaluated``. The best members stay; when one member too many
    is taken, a slot becomes free 2 cycles later. ``store`` ends a first population: ``evaluated``
    is ready again, and ``busy`` falls, N cycles after the cycle that follows ``store``, or N cycles
    after the sorter becomes free if that is later.

    Members
    -------
    fills : In(1)
        First populations are being filled. Only changes while not ``busy`` and while no uncollected
        child has arrived.
    store : In(1)
        Pulse: the first population of ``island`` is complete. Only with ``fills``, in a cycle after
        its last member arrived.
    collect : In(1)
        Pulse: collect a generation of ``island``. Not with ``fills``, and only while not ``busy``.
    merge : In(1)
        Pulse: make the best halves of both islands the population of island 0, and free the slots
        of all other members. Only when ``collect`` is allowed and no child has arrived; not with a
        single island.
    island : In(range(islands))
        Steady with ``store``, and from ``collect`` until ``busy`` falls.
    stay : In(data.ArrayLayout(range(population), survivors))
        Ranks of the survivors; the elites are not among them. Steady during the pass.
    busy : Out(1)
        A population is being collected or moved; rises in the cycle after ``collect`` or ``merge``.
    sorting : Out(1)
        A pass is in progress, a member is being inserted, or a population is being moved.
    stored : Out(1)
        Pulse: the last child has arrived, the pass is over, and all members are sorted.
    evaluated : In(stream.Signature(member_layout))
        Seeds or children with their keys.
    freed : Out(freed_layout)
        ``valid``: ``slot`` is now free.
    rank : In(range(population))
        While not ``busy``: member of ``island`` to read.
    member : Out(member_layout)
        While not ``busy``: the member at the previous cycle's ``rank``.
    feasible : Out(1)
        While not ``busy``: the best path of the last stored population is feasible.
    """

    population: PowerOfTwo(2, 256, "Members of an island.")
    elites: Count(0, "population - 2", "Best members, which stay.")
    survivors: Count(
        1, "population - elites - 1", "Drawn members that stay; the other members are children."
    )
    islands: Count(1, 2)
    slot_bits: Width(1)
    length_bits: Width(1)

    def interface(self):
        self.children = self.population - self.elites - self.survivors
        self.member_layout = member_layout(self.slot_bits, self.length_bits)
        self.freed_layout = data.StructLayout({"valid": 1, "slot": self.slot_bits})
        return {
            "fills": In(1),
            "store": In(1),
            "collect": In(1),
            "merge": In(1),
            "island": In(range(self.islands)),
            "stay": In(data.ArrayLayout(range(self.population), self.survivors)),
            "busy": Out(1),
            "sorting": Out(1),
            "stored": Out(1),
            "evaluated": In(stream.Signature(self.member_layout)),
            "freed": Out(self.freed_layout),
            "rank": In(range(self.population)),
            "member": Out(self.member_layout),
            "feasible": Out(1),
        }

    def elaborate(self, platform):
        m = Module()

        m.submodules.ranking = ranking = Ranking(
            self.population, self.islands, self.slot_bits, self.length_bits
        )
        # Collecting lasts until all members are in the sorter. A pass goes through the ranks of one
        # island, or of both in order to merge them.
        collecting = Signal()
        merging = Signal()
        passing = Signal()
        # The member of the rank is available; it is passed on once the sorter is free.
        there = Signal()
        passes = Signal()
        number = Signal(range(self.islands * self.population))
        following = Signal.like(number)
        rank = number[: len(self.rank)]
        stays = Signal()
        ends = Signal()
        members = ranking.members
        m.d.comb += [
            stays.eq((rank < self.elites) | Cat(rank == each for each in self.stay).any()),
            ends.eq(rank.all()),
            passes.eq(there & members.ready),
            following.eq(number + passes),
        ]
        m.d.sync += [there.eq(passing), number.eq(following)]
        with m.If(self.collect):
            m.d.sync += [collecting.eq(1), passing.eq(1), merging.eq(0)]
        if self.islands > 1:
            with m.If(self.merge):
                m.d.sync += [collecting.eq(1), passing.eq(1), merging.eq(1)]
            with m.If(merging):
                m.d.comb += [stays.eq(~rank[-1]), ends.eq(number.all())]
        with m.If(passes & ends):
            m.d.sync += [passing.eq(0), there.eq(0), number.eq(0)]

        # Children that have arrived.
        came = Signal(range(self.children))
        complete = Signal()
        with m.If(self.evaluated.valid & self.evaluated.ready & ~self.fills):
            m.d.sync += [came.eq(came + 1), complete.eq(came == self.children - 1)]
        with m.If(self.stored):
            m.d.sync += [collecting.eq(0), merging.eq(0), came.eq(0), complete.eq(0)]
        m.d.comb += [
            self.stored.eq(collecting & ~passing & members.ready & (complete | merging)),
            self.busy.eq(collecting | ranking.busy),
            self.sorting.eq(there | ~members.ready),
            self.evaluated.ready.eq(members.ready & ~there & ~complete),
            members.valid.eq(Mux(there, stays, self.evaluated.valid & ~complete)),
            members.p.member.eq(Mux(there, ranking.member, self.evaluated.p)),
            members.p.late.eq(~there),
            ranking.store.eq(self.stored | self.store),
            ranking.island.eq(Mux(merging, 0, self.island)),
            ranking.read.rank.eq(Mux(passing, following, self.rank)),
            ranking.read.island.eq(self.island),
            self.member.eq(ranking.member),
            self.feasible.eq(ranking.feasible),
            self.freed.valid.eq((passes & ~stays) | ranking.dropped.valid),
            self.freed.slot.eq(Mux(there, ranking.member.slot, ranking.dropped.slot)),
        ]
        if self.islands > 1:
            with m.If(merging & passing):
                m.d.comb += ranking.read.island.eq(following[-1])

        return m
