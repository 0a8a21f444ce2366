"""Reader of paths for the host, one waypoint at a time."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.layouts import read_layout, waypoint_layout
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["PathReader"]


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
