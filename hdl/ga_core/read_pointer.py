"""Position of the lock-step reading of the population."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.fanout import fanout
from pathgene.hdl.primitives.unit import Count, Flag, Unit


__all__ = ["PEEK_LATENCY", "ReadPointer"]

#: Cycles from a peek to its waypoints: position, index, slot, port.
PEEK_LATENCY = 4


class ReadPointer(Unit):
    """Advances the reading of all slots, and rewinds it to their first waypoints.

    ``ahead`` is the position to be read next. The two cycles after a rewind fill the registers
    after it: when it is 2, the slots have the waypoints of position 0. ``advance`` and ``step``
    are registers, since they enable the whole population.

    Members
    -------
    taken, writing : In(1)
        A waypoint for the present population is accepted; and, in the next cycle, written.
    update : In(1)
        The next population becomes the present one.
    rewinds : In(1)
        Rewind. Each of the inputs above also rewinds, starting in the second cycle after it, since
        the indices of the slots follow a change of a path a cycle after its length.
    begin : In(1).array(parts)
        A crossover begins with the next cycle. All are equal.
    passes : In(1)
        The ports take waypoints in the next cycle for another reason.
    peek, peek_position : In(1), In(range(max_waypoints))
        Only with ``peeks``: see :class:`pathgene.hdl.ga_core.population.Population`.
    ahead : Out(range(max_waypoints))
    advance : Out(1).array(parts)
        All slots read. All are equal.
    step : Out(1)
        The ports take the waypoints of the slots.
    primes : Out(1)
        The slots have the first waypoints starting in the next cycle.
    primed : Out(1)
        The slots have the first waypoints, or later ones that were passed, and no change or peek is
        in flight.
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
            # The rewind may follow an update a cycle late: waypoints read before the next cycle are
            # discarded, too.
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
