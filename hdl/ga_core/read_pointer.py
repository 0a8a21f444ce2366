"""Position up to which the population is being read, in lock step."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.primitives.arguments import check_integer
from hdl.primitives.fanout import fanout


__all__ = ["PEEK_LATENCY", "ReadPointer"]

#: Clocks from a position that is peeked at to its waypoints: position, index, slot, port.
PEEK_LATENCY = 4


class ReadPointer(wiring.Component):
    """Moves the reading of all slots on, and back to their first waypoints.

    ``ahead`` is the position to be read next. Two clocks after a rewind fill the registers behind
    it: when it is 2, the waypoints of 0 are in the slots. ``advance`` and ``step`` enable so much
    that they are registers.

    Parameters
    ----------
    max_waypoints : int
        Waypoints of the longest path, 3 or more.
    parts : int
        Copies of ``advance``, which reaches all slots: 1 or more.
    peeks : bool
        Whether positions are peeked at.

    Members
    -------
    taken, writing : In(1)
        A waypoint for the present population comes in; and is written in the next clock.
    update : In(1)
        The next population becomes the present one.
    rewinds : In(1)
        The first waypoints are wanted. So they are after each of the above: from the second clock
        after it on, as the slots' indices know what has become of their paths a clock after the
        lengths do.
    begin : In(1).array(parts)
        A crossover begins with the next clock; all are equal.
    passes : In(1)
        The ports take waypoints in the next clock for another reason.
    peek, peek_position : In(1), In(range(max_waypoints))
        Only with ``peeks``: see :class:`hdl.ga_core.population.Population`.
    ahead : Out(range(max_waypoints))
    advance : Out(1).array(parts)
        All slots read.
    step : Out(1)
        The ports take what the slots have.
    primes : Out(1)
        The slots have the first waypoints from the next clock on.
    primed : Out(1)
        They have, or what was asked for after them, and nothing of the above is under way.
    peeking : Out(1)
        A peek is under way, other than one of this clock.

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    def __init__(self, *, max_waypoints, parts, peeks):
        check_integer("Max waypoints", max_waypoints, 3)
        check_integer("Parts", parts, 1)

        self.max_waypoints = max_waypoints
        self.parts = parts
        self.peeks = bool(peeks)
        members = {"peek": In(1), "peek_position": In(range(max_waypoints))}
        super().__init__(
            {
                "taken": In(1),
                "writing": In(1),
                "update": In(1),
                "rewinds": In(1),
                "begin": In(1).array(parts),
                "passes": In(1),
                "ahead": Out(range(max_waypoints)),
                "advance": Out(1).array(parts),
                "step": Out(1),
                "primes": Out(1),
                "primed": Out(1),
                "peeking": Out(1),
                **(members if self.peeks else {}),
            }
        )

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
            # What has been read ahead is of no use after an update, but nothing is until a clock
            # later.
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
        # Whether a crossover begins is known last.
        advances = self.passes | looks | rewind | filling[1]
        advance = fanout(m, *(begin | advances for begin in self.begin), name="advance", init=1)
        m.d.comb += [port.eq(copy) for port, copy in zip(self.advance, advance, strict=True)]
        with m.If(advance[0]):
            m.d.sync += self.ahead.eq(self.ahead + 1)
        if self.peeks:
            # The reading jumps, and the three registers behind the position take what is there;
            # with the last of them it rewinds.
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
