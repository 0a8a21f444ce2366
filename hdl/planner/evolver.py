"""Evolver: the populations of a run, generation after generation; evaluation is elsewhere."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import exact_log2

from hdl.planner.breeder import Breeder
from hdl.planner.population_layouts import KEY_BITS, slot_count
from hdl.planner.population_memory import PopulationMemory
from hdl.planner.ranking import Ranking
from hdl.planner.slot_pool import SlotPool
from hdl.primitives.arguments import check_power_of_two
from hdl.primitives.multiplexer import multiplex
from hdl.protocol.random_words import LANES, WORD_BITS


__all__ = ["Evolver"]


class Evolver(wiring.Component):
    """Holds the populations of all islands and breeds their next generations.

    A generation reads the keys that decide about children, breeds the children, ranks elites and
    survivors, and puts the slots of all other members back. The children come back with their keys
    in the order in which they went out. With the last of them the new population is complete, moves
    to the memory of the :class:`hdl.planner.ranking.Ranking`, and the next generation may begin:
    its first point is offered ``24 + give_up_rank`` cycles after the last child has come back, or
    later if a rank behind that one is to be read. Equals
    :meth:`sim.model.planner.definition.run.Run.breed`, evaluation apart.

    Slots are not bound to an island. So the best members of all islands become one population by
    their ranks alone; no waypoint moves. The slots of the others stay unused until ``clear``.

    Parameters
    ----------
    config : Config
    islands : int
        A power of two, 1 to 16, at most the population.

    Members
    -------
    clear : In(1)
        Free all slots, for a new run. Only while not ``busy``.
    fills : In(1)
        First populations come: members, of which the best stay, from ``evaluated``, and their
        waypoints from ``write``. Changes only while not ``busy``.
    store : In(1)
        Pulse: the first population of ``island`` is complete. Only with ``fills``.
    begin : In(1)
        Breed a generation of ``island``, if ``ready``. Not with ``fills``.
    merge : In(1)
        Make the best members of the first ``2 ** merged`` islands, an equal number of each, the
        population of ``island``, if ``ready``. Not with ``fills``.
    island : In(range(islands))
        With ``store``, and from ``begin`` or ``merge`` until ``ready``.
    merged : In(range(log2(islands) + 1))
        With ``merge``, until ``ready``.
    ready : Out(1)
        No generation is being bred.
    busy : Out(1)
        Not ``ready``, or a population is being moved.
    give_up_rank : In(config.slot_bits)
        Steady during a generation.
    best, limit : Out(KEY_BITS)
        Keys of rank 0 and of ``give_up_rank`` of the population of which children are bred. Valid
        from the first child until ``ready``.
    words : In(stream.Signature(data.ArrayLayout(64, 2)))
        Steps of the random source: selection word, mutation word.
    limits, start, goal : In(corner_layout)
        Greatest corner and altitude of a waypoint, and the ends of all paths. Steady.
    slots : Out(stream.Signature(range(slot_count)))
        With ``fills``: free slots, of which at most ``config.children`` are taken that have not
        come back in ``evaluated``.
    write : In(write_layout)
        With ``fills``: a waypoint to be written.
    children : Out(stream.Signature(child_layout))
        Slot and length of each child, before its points.
    points : Out(stream.Signature(point_layout))
        Points of the children, start and goal included; ``last`` marks the goal.
    margins : In(stream.Signature(margin_layout))
        Margins to be written, those of a path before it comes in ``evaluated``.
    evaluated : In(stream.Signature(member_layout))
        Paths with their keys, in the order of ``children``.
    rank : In(config.slot_bits)
        While not ``busy``: member of ``island`` to be read.
    member : Out(member_layout)
        While not ``busy``: the member of ``rank`` of the cycle before.
    read : In(place_layout)
        While ``ready``: place of a waypoint to be read.
    waypoint : Out(waypoint_layout)
        While ``ready``: the waypoint at ``read`` of 2 cycles before.

    Raises
    ------
    TypeError, ValueError
        If ``islands`` is not an integer, or out of its range.
    """

    def __init__(self, config, islands):
        check_power_of_two("Islands", islands, 1, min(16, config.population))

        self.config = config
        self.islands = islands
        self.slot_count = slot_count(config, islands)
        self.slot_bits = (self.slot_count - 1).bit_length()
        self.breeder = Breeder(config, islands)
        self.memory = PopulationMemory(
            self.slot_count, config.max_waypoints, config.coordinate_bits, config.altitude_bits
        )
        self.ranking = Ranking(config.population, islands, self.slot_bits, config.length_bits)
        self.member_layout = self.ranking.member_layout
        bred = self.breeder.signature.members
        super().__init__(
            {
                "clear": In(1),
                "fills": In(1),
                "store": In(1),
                "begin": In(1),
                "merge": In(1),
                "island": In(range(islands)),
                "merged": In(range(exact_log2(islands) + 1)),
                "ready": Out(1),
                "busy": Out(1),
                "give_up_rank": In(config.slot_bits),
                "best": Out(KEY_BITS),
                "limit": Out(KEY_BITS),
                "words": In(stream.Signature(data.ArrayLayout(WORD_BITS, LANES))),
                **{name: bred[name] for name in ("limits", "start", "goal")},
                "slots": Out(stream.Signature(range(self.slot_count))),
                "write": In(self.memory.write_layout),
                **{name: bred[name] for name in ("children", "points")},
                "margins": In(stream.Signature(self.memory.margin_layout)),
                "evaluated": In(stream.Signature(self.member_layout)),
                "rank": In(config.slot_bits),
                "member": Out(self.member_layout),
                "read": In(self.memory.place_layout),
                "waypoint": Out(self.memory.waypoint_layout),
            }
        )

    def elaborate(self, platform):
        m = Module()

        m.submodules.breeder = breeder = self.breeder
        m.submodules.memory = memory = self.memory
        m.submodules.ranking = ranking = self.ranking
        m.submodules.pool = pool = SlotPool(self.slot_count, self.config.children)
        for name in ("words", "children", "points"):
            connect(m, flipped(getattr(self, name)), getattr(breeder, name))
        connect(m, flipped(self.margins), memory.margins)
        m.d.comb += [
            *(
                getattr(breeder, name).eq(getattr(self, name))
                for name in ("limits", "start", "goal")
            ),
            breeder.waypoint.eq(memory.waypoint),
            breeder.parent.slot.eq(ranking.member.slot),
            breeder.parent.length.eq(ranking.member.length),
            self.waypoint.eq(memory.waypoint),
            self.member.eq(ranking.member),
            memory.read.eq(Mux(self.ready, self.read, breeder.read)),
            memory.write.eq(Mux(self.fills, self.write, breeder.write)),
            pool.clear.eq(self.clear),
            breeder.slots.p.eq(pool.slots.p),
            breeder.slots.valid.eq(pool.slots.valid & ~self.fills),
            self.slots.p.eq(pool.slots.p),
            self.slots.valid.eq(pool.slots.valid & self.fills),
            pool.slots.ready.eq(Mux(self.fills, self.slots.ready, breeder.slots.ready)),
            ranking.keeps_best.eq(self.fills),
            ranking.island.eq(self.island),
            self.busy.eq(~self.ready | ranking.busy),
        ]
        self._generate(m)

        return m

    def _generate(self, m):
        """Go through the steps of a generation."""
        config, breeder, ranking = self.config, self.breeder, self.ranking
        pool, read = m.submodules.pool, ranking.read
        rank_bits = config.slot_bits
        # Ranks of elites and survivors, then all ranks; or places of the merged population.
        number = Signal(rank_bits)
        kept_ranks = [*(C(rank, rank_bits) for rank in range(config.elites)), *breeder.survivors]
        merging = Signal()
        last_kept = Mux(merging, config.population - 1, len(kept_ranks) - 1)
        # Those consist of equal numbers of each island.
        merged_rank = Signal(rank_bits)
        merged_island = Signal(range(self.islands))
        with m.Switch(self.merged):
            for merged in range(exact_log2(self.islands) + 1):
                with m.Case(merged):
                    each = rank_bits - merged
                    m.d.comb += [merged_rank.eq(number[:each]), merged_island.eq(number[each:])]

        # What happens to the member read in the cycle before.
        gives_best = Signal()
        gives_limit = Signal()
        is_freed = Signal()
        is_best = Signal()
        is_limit = Signal()
        frees = Signal()
        keeps = Signal()
        keeps_taken = Signal()
        m.d.sync += [is_best.eq(gives_best), is_limit.eq(gives_limit), frees.eq(is_freed)]
        with m.If(is_best):
            m.d.sync += self.best.eq(ranking.member.key)
        with m.If(is_limit):
            m.d.sync += self.limit.eq(ranking.member.key)
        members = ranking.members
        m.d.comb += [
            pool.put.eq(frees | ranking.dropped.valid),
            pool.slot.eq(Mux(frees, ranking.member.slot, ranking.dropped.slot)),
            # Children first. Those kept take their places among them by their keys.
            members.valid.eq(self.evaluated.valid | keeps),
            members.p.member.eq(Mux(self.evaluated.valid, self.evaluated.p, ranking.member)),
            members.p.late.eq(self.evaluated.valid & ~self.fills),
            self.evaluated.ready.eq(members.ready),
            keeps_taken.eq(keeps & members.ready & ~self.evaluated.valid),
        ]
        with m.If(keeps_taken):
            m.d.sync += keeps.eq(0)

        is_read = Signal()
        m.d.comb += [
            is_read.eq(read.valid & ranking.readable),
            read.island.eq(self.island),
            read.rank.eq(self.rank),
            ranking.store.eq(self.store),
        ]
        with m.FSM():
            with m.State("READY"):
                m.d.comb += [self.ready.eq(1), read.valid.eq(1), breeder.begin.eq(self.begin)]
                m.d.sync += [number.eq(0), merging.eq(self.merge)]
                with m.If(self.begin):
                    m.next = "BEST"
                with m.Elif(self.merge):
                    m.next = "KEEP"
            with m.State("BEST"):
                m.d.comb += [read.valid.eq(1), read.rank.eq(0), gives_best.eq(is_read)]
                with m.If(is_read):
                    m.next = "LIMIT"
            with m.State("LIMIT"):
                m.d.comb += [
                    read.valid.eq(1),
                    read.rank.eq(self.give_up_rank),
                    gives_limit.eq(is_read),
                ]
                with m.If(is_read):
                    m.next = "BREED"
            with m.State("BREED"):
                m.d.comb += [
                    read.valid.eq(breeder.reads),
                    read.rank.eq(breeder.rank),
                    breeder.readable.eq(ranking.readable),
                ]
                with m.If(~breeder.planning):
                    m.next = "KEEP"
            with m.State("KEEP"):
                m.d.comb += [
                    read.valid.eq(~keeps | keeps_taken),
                    read.rank.eq(Mux(merging, merged_rank, multiplex(number, kept_ranks))),
                ]
                with m.If(merging):
                    m.d.comb += read.island.eq(merged_island)
                with m.If(is_read):
                    m.d.sync += [keeps.eq(1), number.eq(number + 1)]
                    with m.If(number == last_kept):
                        m.d.sync += number.eq(0)
                        m.next = "KEPT"
            with m.State("KEPT"):
                with m.If(keeps_taken):
                    m.next = "FREE"
                    with m.If(merging):
                        m.next = "SORT"
            with m.State("FREE"):
                is_kept = Cat(number == rank for rank in breeder.survivors).any()
                m.d.comb += [
                    read.valid.eq(1),
                    read.rank.eq(number),
                    is_freed.eq(is_read & (number >= config.elites) & ~is_kept),
                ]
                with m.If(is_read):
                    m.d.sync += number.eq(number + 1)
                    with m.If(number == config.population - 1):
                        m.next = "SORT"
            with m.State("SORT"):
                with m.If(ranking.full & ~breeder.building):
                    m.d.comb += ranking.store.eq(1)
                    m.next = "READY"
