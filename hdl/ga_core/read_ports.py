"""Read ports of the population: positions, pointers, the choice of a slot, the reader of paths."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.layouts import read_layout, waypoint_layout
from pathgene.hdl.primitives.logic import fanout, one_hot_multiplex_tree
from pathgene.hdl.primitives.unit import Count, Flag, Unit, Width


__all__ = ["PEEK_LATENCY", "PathReader", "PositionCounter", "ReadCrossbar", "ReadPointer"]


class PositionCounter(Unit):
    """Counts positions until the longest path has passed.

    ``running`` and ``following`` lead the waypoints in the ports by one cycle. All outputs except
    ``goes_on`` are registers, because they reach the whole population.

    Members
    -------
    begin : In(1)
        Pulse in the cycle before the crossover's first. Never during a crossover.
    lengths : In(range(max_waypoints + 1)).array(ports)
        Length of the path of each port, 2 or more. Steady from ``begin`` to ``done``.
    goes_on : Out(1)
        ``running`` in this cycle and in the next. Combinational.
    running : Out(1)
        The ports take the waypoints at ``following``. High from the first cycle of the crossover
        on, for as many cycles as the longest path has waypoints.
    following : Out(range(max_waypoints))
        0, 1, ... while ``running``.
    carrying, position : Out(1), Out(range(max_waypoints))
        ``running`` and ``following`` of the previous cycle: the ports hold those waypoints.
    done : Out(1)
        High in the cycle after the last with ``running``.
    """

    ports: Count(1, text="Paths that pass at once.")
    max_waypoints: Count(3, text="Waypoints of the longest path.")

    def interface(self):
        return {
            "begin": In(1),
            "lengths": In(range(self.max_waypoints + 1)).array(self.ports),
            "goes_on": Out(1),
            "running": Out(1),
            "following": Out(range(self.max_waypoints)),
            "carrying": Out(1),
            "position": Out(range(self.max_waypoints)),
            "done": Out(1),
        }

    def elaborate(self, platform):
        m = Module()

        # `last` takes three cycles: each length is compared for a later waypoint, then all results
        # are combined. Therefore `third` is three past `following`.
        last = Signal()
        third = Signal(range(self.max_waypoints + 3), init=2)
        ended = Signal(len(self.lengths), reset_less=True)
        passes = self.begin | self.goes_on
        m.d.comb += self.goes_on.eq(self.running & ~last)
        m.d.sync += [
            self.running.eq(passes),
            self.following.eq(Mux(self.running, self.following + 1, 0)),
            third.eq(Mux(passes, third + 1, 2)),
            ended.eq(Cat(length <= third for length in self.lengths)),
            last.eq(self.running & ~last & ended.all()),
            self.carrying.eq(self.running),
            self.position.eq(self.following),
            self.done.eq(last),
        ]

        return m


#: Cycles from a peek to its waypoints: position, index, slot, port.
PEEK_LATENCY = 4


class ReadPointer(Unit):
    """Advances the reading of all slots, and rewinds it to their first waypoints.

    ``ahead`` is the next position to be read. The two cycles after a rewind fill the registers that
    follow: when it is 2, the slots have the waypoints of position 0. ``advance`` and ``step`` are
    registers, because they enable the whole population.

    Members
    -------
    taken, writing : In(1)
        A waypoint for the current population is accepted; it is written in the next cycle.
    update : In(1)
        The next population becomes the current one.
    rewinds : In(1)
        Rewind. Each of the inputs above also rewinds, from the second cycle after it on, because
        the indices of the slots follow a change of a path one cycle after its length.
    begin : In(1).array(parts)
        A crossover begins in the next cycle. All bits are equal.
    passes : In(1)
        The ports take waypoints in the next cycle for another reason.
    peek, peek_position : In(1), In(range(max_waypoints))
        Only with ``peeks``: see :class:`pathgene.hdl.ga_core.population.Population`.
    ahead : Out(range(max_waypoints))
    advance : Out(1).array(parts)
        All slots read. All bits are equal.
    step : Out(1)
        The ports take the waypoints of the slots.
    primes : Out(1)
        The slots have the first waypoints from the next cycle on.
    primed : Out(1)
        The slots have the first waypoints, or later ones after a pass, and no change or peek is in
        flight.
    peeking : Out(1)
        A peek of an earlier cycle is in flight.
    """

    max_waypoints: Count(3, text="Waypoints of the longest path.")
    parts: Count(1, text="Parts of the slots, each of which has an ``advance``.")
    peeks: Flag("The unit has the members for peeks.")

    def interface(self):
        members = {"peek": In(1), "peek_position": In(range(self.max_waypoints))}
        return {
            "taken": In(1),
            "writing": In(1),
            "update": In(1),
            "rewinds": In(1),
            "begin": In(1).array(self.parts),
            "passes": In(1),
            "ahead": Out(range(self.max_waypoints)),
            "advance": Out(1).array(self.parts),
            "step": Out(1),
            "primes": Out(1),
            "primed": Out(1),
            "peeking": Out(1),
            **(members if self.peeks else {}),
        }

    def elaborate(self, platform):
        m = Module()

        filling = Signal(2, init=0b11)
        changed = Signal(init=1)
        rewind = Signal()
        occupied = Signal()
        looks = Signal()
        looked_last = Signal()
        steps = Signal()
        m.d.comb += [
            # The rewind may follow an update one cycle late, because waypoints read before the next
            # cycle are discarded too.
            rewind.eq(self.rewinds | changed),
            steps.eq(self.begin[0] | self.passes | looks),
            self.primes.eq(~filling[1]),
            self.primed.eq(~filling[0] & ~occupied),
        ]
        m.d.sync += [
            changed.eq(self.taken | self.writing | self.update | looked_last),
            filling.eq(Mux(rewind, 0b11, filling[1])),
            occupied.eq(self.taken | self.update | looks),
            self.step.eq(steps),
        ]
        # `begin` arrives last.
        advances = self.passes | looks | rewind | filling[1]
        advance = fanout(m, *(begin | advances for begin in self.begin), name="advance", init=1)
        m.d.comb += [port.eq(copy) for port, copy in zip(self.advance, advance, strict=True)]
        with m.If(advance[0]):
            m.d.sync += self.ahead.eq(self.ahead + 1)
        if self.peeks:
            # A peek moves the pointer; three registers after it take the waypoints in turn. The
            # pointer rewinds when the last of them has been taken.
            looked = Signal(PEEK_LATENCY - 2)
            m.d.comb += [
                looks.eq(self.peek | looked.any()),
                looked_last.eq(looked[-1] & ~looked[-2]),
            ]
            m.d.sync += [looked.eq(Cat(self.peek, looked)), self.peeking.eq(looks)]
            with m.If(self.peek):
                m.d.sync += self.ahead.eq(self.peek_position)
        with m.If(rewind):
            m.d.sync += self.ahead.eq(0)

        return m


_PORTS_OF_PART = 3


class ReadCrossbar(Unit):
    """One register per port, with a multiplexer of all slots: the largest unit of the chip.

    A port also registers its selection, because the selection reaches the whole multiplexer.

    Members
    -------
    selects : In(population).array(ports)
        The slot of each port, decoded: at most one bit is set. It takes effect in the next cycle.
    slots : In(waypoint_bits).array(population)
        Current waypoint of each slot.
    step : In(1)
        The first port takes its waypoint. All other ports take theirs in every cycle.
    writing : In(1).array(parts_of(ports))
        All ports take ``written`` instead. All bits are equal; each drives some of the ports.
        Overrides ``step``.
    written : In(waypoint_bits)
    waypoints : Out(waypoint_bits).array(ports)
        Waypoint that each port took in the previous cycle, or the first port at its latest
        ``step``.
    """

    ports: Count(1)
    population: Count(2, text="Slots.")
    waypoint_bits: Width(1)

    @staticmethod
    def parts_of(ports: int) -> int:
        """Return the number of parts into which the ports are divided for ``writing``."""
        return -(-ports // _PORTS_OF_PART)

    def interface(self):
        return {
            "selects": In(self.population).array(self.ports),
            "slots": In(self.waypoint_bits).array(self.population),
            "step": In(1),
            "writing": In(1).array(self.parts_of(self.ports)),
            "written": In(self.waypoint_bits),
            "waypoints": Out(self.waypoint_bits).array(self.ports),
        }

    def elaborate(self, platform):
        m = Module()

        for number, (select, waypoint) in enumerate(zip(self.selects, self.waypoints, strict=True)):
            chosen = Signal(len(select), name=f"select_{number}", reset_less=True)
            port = Signal(len(waypoint), name=f"port_{number}", reset_less=True)
            m.d.sync += chosen.eq(select)
            # Not inside a condition, which would add an input to every look-up table.
            passing = one_hot_multiplex_tree(m, chosen, self.slots, f"of_slots_{number}")
            m.d.comb += waypoint.eq(port)
            with m.If(self.writing[number // _PORTS_OF_PART]):
                m.d.sync += port.eq(self.written)
            with m.Elif(self.step if number == 0 else C(1)):
                m.d.sync += port.eq(passing)

        return m


class PathReader(Unit):
    """Converts the lockstep reading of the population to a stream of one path after another.

    It rewinds the reading before each path and after the last one. A step moves the next waypoint
    of ``slot`` to the register ``waypoint``. There are 3 cycles between two paths.

    A waypoint that is not transferred moves to a second register, which makes room for another.
    Therefore a step does not depend on ``waypoints.ready`` of the same cycle, which would have to
    reach the whole population.

    Members
    -------
    reads : In(stream.Signature(read_layout))
        ``count`` is 1 or more.
    allow : In(1)
        A read is accepted.
    waypoints : Out(stream.Signature(waypoint_layout))
    active : Out(1)
        A read is in flight: the population must not change.
    slot : Out(slot_bits)
        Slot being read.
    length : In(range(max_waypoints + 1))
        Length of its path, two cycles after ``slot``.
    rewind : Out(1)
    primes : In(1)
        The reading is rewound and can be stepped from the next cycle on.
    steps : Out(1)
        The reading steps in the next cycle.
    waypoint : In(waypoint_bits)
    """

    slot_bits: Width(1)
    waypoint_bits: Width(1)
    max_waypoints: Count(3, text="Waypoints of the longest path.")

    def interface(self):
        return {
            "reads": In(stream.Signature(read_layout(self.slot_bits))),
            "allow": In(1),
            "waypoints": Out(stream.Signature(waypoint_layout(self.waypoint_bits))),
            "active": Out(1),
            "slot": Out(self.slot_bits),
            "length": In(range(self.max_waypoints + 1)),
            "rewind": Out(1),
            "primes": In(1),
            "steps": Out(1),
            "waypoint": In(self.waypoint_bits),
        }

    def elaborate(self, platform):
        m = Module()
        waypoints = self.waypoints

        # Flags of the next waypoint: it ends its path (`last`), and the last path (`final`). They
        # are computed one cycle ahead; `second` is two past its position, which every path allows.
        left = Signal.like(self.reads.p.count)
        second = Signal(len(self.length) + 1)
        last = Signal()
        only = Signal()
        final = Signal()
        m.d.sync += only.eq(left == 1)
        m.d.comb += final.eq(last & only)

        # The waypoint in the register, and the previous one if it has moved to the second register.
        loaded = Signal()
        present = Signal.like(waypoints.p)
        ends = Signal()
        ends_all = Signal()
        reading = Signal()
        step = Signal()
        full = Signal()
        aside = Signal.like(waypoints.p, reset_less=True)
        m.d.comb += [
            present.waypoint.eq(self.waypoint),
            present.last.eq(ends),
            present.final.eq(ends_all),
            waypoints.valid.eq(loaded | full),
            waypoints.p.eq(Mux(full, aside, present)),
        ]
        with m.If(full):
            with m.If(waypoints.ready):
                m.d.sync += full.eq(0)
        with m.Else():
            m.d.sync += aside.eq(present)
            with m.If(step):
                m.d.sync += [loaded.eq(1), full.eq(loaded & ~waypoints.ready)]
            with m.Elif(waypoints.ready):
                m.d.sync += loaded.eq(0)
        with m.If(step):
            m.d.sync += [
                ends.eq(last),
                ends_all.eq(final),
                last.eq(second == self.length),
                second.eq(second + 1),
            ]

        # A step is decided one cycle ahead. There is none after the last waypoint of a path, nor
        # while both registers are full.
        room = Signal()
        m.d.comb += [
            room.eq(waypoints.ready | ~(full | (loaded & step))),
            self.steps.eq(reading & ~(step & last) & self.primes & room),
        ]
        m.d.sync += step.eq(self.steps)
        with m.FSM():
            with m.State("Idle"):
                m.d.comb += self.reads.ready.eq(self.allow)
                m.d.sync += [self.slot.eq(self.reads.p.slot), left.eq(self.reads.p.count)]
                with m.If(self.reads.valid & self.allow):
                    m.d.sync += self.active.eq(1)
                    m.next = "Rewind"

            with m.State("Rewind"):
                m.d.comb += self.rewind.eq(1)
                m.d.sync += [second.eq(2), last.eq(0), reading.eq(1)]
                m.next = "Read"

            with m.State("Read"):
                with m.If(step & last):
                    m.d.sync += [self.slot.eq(self.slot + 1), left.eq(left - 1), reading.eq(0)]
                    m.next = "Rewind"
                    with m.If(final):
                        m.next = "Drain"

            with m.State("Drain"):
                m.d.comb += self.rewind.eq(1)
                with m.If(waypoints.ready & waypoints.p.final):
                    m.d.sync += self.active.eq(0)
                    m.next = "Idle"

        return m
