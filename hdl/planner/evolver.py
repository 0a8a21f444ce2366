"""Evolver of the populations of a run, generation after generation, without evaluation."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import Config
from pathgene.hdl.planner.breeder import Breeder
from pathgene.hdl.planner.collector import Collector
from pathgene.hdl.planner.layouts import KEY_BITS, corner_layout, head_layout, slot_count
from pathgene.hdl.planner.population_memory import PopulationMemory, SlotPool, write_layout
from pathgene.hdl.primitives.unit import Count, InstanceOf, Unit
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from pathgene.hdl.protocol.random_words import LANES, WORD_BITS


__all__ = ["Evolver"]

_AXES = ("x", "y", "altitude")


class Evolver(Unit):
    """Stores the populations of all islands and breeds their next generations.

    Two generations overlap, so that units do not wait for each other: while the children of one are
    evaluated, the children of the next are planned from the current population. Then the earlier
    generation is collected: elites and the survivors drawn last stay, the children replace all
    other members, and the slots of these become free. ``finish`` collects a generation without
    planning another one. Except for evaluation, it equals
    :func:`pathgene.sim.model.planner.run.plan`.

    Planning takes a constant number of cycles, whatever is drawn; passes over the ranks and sorting
    take longer the more members are passed. :mod:`pathgene.sim.model.planner.evolver_cycles` has
    all cycles, including the cycles in which the points of a child are ready. The builder may be
    ahead of these by 5 children, and ``children`` should be taken that early.

    Slots are not bound to an island. Therefore the best members of two islands become one
    population just by their ranks, without moving waypoints. A slot that becomes free may still
    hold a parent of children to be built. It is handed out after all slots that became free before
    it, whose number equals the children of a generation.

    A first population may be new, in slots from ``slots``, or the current population of ``island``,
    in which case each member is read by its rank, rewritten in its slot, and evaluated. Nothing has
    to be cleared before an island gets a population in this way: after ``finish`` or ``merge``, a
    run may continue from the population of island 0 and refill island 1.

    Members
    -------
    clear : In(1)
        Free all slots. Only while ``ready`` and not ``pending``.
    fills : In(1)
        First populations are being filled: members, of which the best stay, from ``evaluated``, and
        corners of their waypoints from ``write``. Only changes while ``ready`` and not ``pending``.
    store : In(1)
        Pulse: the first population of ``island`` is complete. Only with ``fills``, in a cycle after
        its last member arrived. ``ready`` is low from the next cycle on.
    begin : In(1)
        Pulse: breed a generation of ``island``, and collect the previous one if it is ``pending``.
        Only while ``ready``, and not with ``fills``.
    finish : In(1)
        Pulse: collect the ``pending`` generation, if any. Only while ``ready``.
    merge : In(1)
        Pulse: make the best halves of islands 0 and 1 the population of island 0. Only while
        ``ready`` and not ``pending``, and not with ``fills``. Without effect if there is one
        island.
    island : In(range(islands))
        Steady with ``store``, and from ``begin`` until ``ready`` and not ``pending``.
    ready : Out(1)
        No generation is being planned or collected, and no population is being moved. All ranks can
        be read.
    pending : Out(1)
        A generation has been bred but not collected.
    planning, sorting : Out(1)
        Children are being planned; members are being passed over, inserted or moved.
    give_up_rank : In(config.slot_bits)
        Steady while not ``ready``.
    best : Out(KEY_BITS)
        Key of rank 0 of the population from which the last children were bred.
    feasible : Out(1)
        While ``ready``: the best path of the last sorted population is feasible.
    words : In(stream.Signature(data.ArrayLayout(64, 2)))
        Steps of the random source: selection word, mutation word. Planning waits while there is
        none.
    frame : In(frame_layout)
        Maximum corner and altitude of a waypoint, and the common ends of all paths. Steady.
    slots : Out(stream.Signature(range(slot_count)))
        With ``fills``: free slots. At most ``max(2 * config.children, 18)`` slots are taken and not
        yet returned by ``evaluated``.
    write : In(write_layout)
        With ``fills``: corner and altitude of a waypoint to be written.
    children : Out(stream.Signature(head_layout))
        Slot and limit of each child. Taken no later than its first point.
    points : Out(stream.Signature(point_layout))
        Points of the children, start and goal included; ``last`` marks the goal.
    decided : In(decided_layout)
        ``valid``: the path in ``slot``, whose points have been taken, is ``walked`` or not.
        Precedes its key. All paths of first populations are walked.
    margin : In(margin_layout)
        ``valid``: the margin of a waypoint of a walked path. The margins of all waypoints of the
        path precede its key, in any cycles after its points.
    evaluated : In(stream.Signature(member_layout))
        Paths with their keys, in the order of ``children``. Not ready while members are being
        sorted.
    rank : In(config.slot_bits)
        While ``ready``: member of ``island`` to read.
    member : Out(member_layout)
        While ``ready``: the member at the previous cycle's ``rank``.
    read : In(place_layout)
        While not ``pending``: place of a waypoint to read.
    waypoint : Out(waypoint_layout)
        While not ``pending``: the waypoint at ``read`` from 2 cycles before.
    """

    config: InstanceOf(Config)
    islands: Count(1, 2)

    def interface(self):
        config = self.config
        self.slot_count = slot_count(config, self.islands)
        self.slot_bits = (self.slot_count - 1).bit_length()
        self.breeder = Breeder(config, self.islands)
        self.memory = PopulationMemory(
            self.slot_count, config.max_waypoints, config.coordinate_bits, config.altitude_bits
        )
        self.collector = Collector(
            config.population,
            config.elites,
            config.survivors,
            self.islands,
            self.slot_bits,
            config.length_bits,
        )
        self.member_layout = self.collector.member_layout
        self.head_layout = head_layout(self.slot_bits)
        bred = self.breeder.signature.members
        corner = corner_layout(config.coordinate_bits, config.altitude_bits)
        return {
            "clear": In(1),
            "fills": In(1),
            "store": In(1),
            "begin": In(1),
            "finish": In(1),
            "merge": In(1),
            "island": In(range(self.islands)),
            "ready": Out(1),
            "pending": Out(1),
            "planning": Out(1),
            "sorting": Out(1),
            "give_up_rank": In(config.slot_bits),
            "best": Out(KEY_BITS),
            "feasible": Out(1),
            "words": In(stream.Signature(data.ArrayLayout(WORD_BITS, LANES))),
            "frame": bred["frame"],
            "slots": Out(stream.Signature(range(self.slot_count))),
            "write": In(write_layout(self.slot_count, config.max_waypoints, corner)),
            "children": Out(stream.Signature(self.head_layout)),
            "points": bred["points"],
            "decided": In(self.memory.decided_layout),
            "margin": In(self.memory.margin_layout),
            "evaluated": In(stream.Signature(self.member_layout)),
            "rank": In(config.slot_bits),
            "member": Out(self.member_layout),
            "read": In(self.memory.place_layout),
            "waypoint": Out(self.memory.waypoint_layout),
        }

    def elaborate(self, platform):
        m = Module()

        m.submodules.breeder = breeder = self.breeder
        m.submodules.memory = memory = self.memory
        m.submodules.collector = collector = self.collector
        # All slots may be waiting for children that are not yet built, except slots of members that
        # stay.
        m.submodules.pool = pool = SlotPool(self.slot_count, self.slot_count)
        connect(m, flipped(self.words), breeder.words)
        connect(m, flipped(self.points), breeder.points)
        connect(m, flipped(self.evaluated), collector.evaluated)
        m.d.comb += [
            breeder.frame.eq(self.frame),
            breeder.waypoint.eq(memory.waypoint),
            breeder.parent.slot.eq(collector.member.slot),
            breeder.parent.length.eq(collector.member.length),
            self.waypoint.eq(memory.waypoint),
            self.member.eq(collector.member),
            # Waypoints are read while children may be built.
            memory.read.eq(Mux(self.pending, breeder.read, self.read)),
            memory.decided.eq(self.decided),
            memory.margin.eq(self.margin),
            memory.write.eq(breeder.write),
            pool.clear.eq(self.clear),
            pool.put.eq(collector.freed.valid),
            pool.slot.eq(collector.freed.slot),
            breeder.slots.p.eq(pool.slots.p),
            breeder.slots.valid.eq(pool.slots.valid & ~self.fills),
            self.slots.p.eq(pool.slots.p),
            self.slots.valid.eq(pool.slots.valid & self.fills),
            pool.slots.ready.eq(Mux(self.fills, self.slots.ready, breeder.slots.ready)),
            collector.fills.eq(self.fills),
            collector.store.eq(self.store),
            collector.merge.eq(self.merge),
            collector.island.eq(self.island),
            collector.stay.eq(breeder.survivors),
            self.sorting.eq(collector.sorting),
            self.feasible.eq(collector.feasible),
        ]
        # A first path inherits no valid margins, because it is walked.
        with m.If(self.fills):
            m.d.comb += [
                memory.write.valid.eq(self.write.valid),
                memory.write.place.eq(self.write.place),
                *(memory.write.waypoint[axis].eq(self.write.waypoint[axis]) for axis in _AXES),
            ]
        self._limit(m, *self._generate(m))

        return m

    def _generate(self, m):
        """Go through the steps of a generation; return reads of rank 0 and of the give-up rank."""
        breeder, collector = self.breeder, self.collector
        # A generation was pending at the last `begin`; the collected generation is the last one.
        was_pending = Signal()
        finishing = Signal()
        gives_best = Signal()
        gives_limit = Signal()
        m.d.comb += collector.rank.eq(self.rank)
        with m.If(collector.stored & finishing):
            m.d.sync += self.pending.eq(0)
        with m.FSM() as states:
            with m.State("READY"):
                m.d.comb += [
                    self.ready.eq(~collector.busy),
                    breeder.begin.eq(self.begin),
                    collector.collect.eq(self.finish & self.pending),
                ]
                m.d.sync += was_pending.eq(self.pending)
                with m.If(self.begin | self.finish):
                    m.d.sync += finishing.eq(self.finish)
                with m.If(self.begin):
                    m.d.sync += self.pending.eq(1)
                    m.next = "BEST"
            with m.State("BEST"):
                m.d.comb += [collector.rank.eq(0), gives_best.eq(1)]
                m.next = "LIMIT"
            with m.State("LIMIT"):
                m.d.comb += [collector.rank.eq(self.give_up_rank), gives_limit.eq(1)]
                m.next = "PLAN"
            with m.State("PLAN"):
                m.d.comb += collector.rank.eq(breeder.rank)
                with m.If(~breeder.planning):
                    m.d.comb += collector.collect.eq(was_pending)
                    m.next = "READY"
        m.d.comb += self.planning.eq(~states.ongoing("READY"))
        return gives_best, gives_limit

    def _limit(self, m, gives_best, gives_limit):
        """Store the limits for the children of each of the two generations."""
        breeder, key = self.breeder, self.collector.member.key
        limit_layout = data.StructLayout({"first": 1, "limited": 1, "limit": VALUE_BITS})
        limits = [Signal(limit_layout, name=f"limit_{parity}") for parity in range(2)]
        is_best = Signal()
        is_limit = Signal()
        m.d.sync += [is_best.eq(gives_best), is_limit.eq(gives_limit)]
        with m.If(is_best):
            m.d.sync += self.best.eq(key)
        is_feasible = key[VALUE_BITS:] == PathClass.FEASIBLE
        for parity, kept in enumerate(limits):
            with m.If(breeder.parity == parity):
                with m.If(is_best):
                    m.d.sync += kept.first.eq(is_feasible)
                with m.If(is_limit):
                    m.d.sync += [kept.limited.eq(is_feasible), kept.limit.eq(key[:VALUE_BITS])]
        child = breeder.children
        limit = data.View(limit_layout, Mux(child.p.parity, *reversed(limits)))
        m.d.comb += [
            self.children.valid.eq(child.valid),
            child.ready.eq(self.children.ready),
            self.children.p.slot.eq(child.p.slot),
            *(self.children.p[name].eq(limit[name]) for name, _ in limit_layout),
        ]
