"""Position up to which the population is being read, in lock step."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.config import CheckerBuild, Config
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
    config : Config
    parts : int
        Copies of ``advance``, which reaches all slots.

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
    peek, peek_position : In(1), In(index_bits)
        Only with a map: see :class:`hdl.ga_core.population.Population`.
    ahead : Out(index_bits)
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
    """

    def __init__(self, config: Config, parts: int):
        self.config = config
        self.peeks = config.checker is not CheckerBuild.NONE
        peeks = {"peek": In(1), "peek_position": In(config.index_bits)}
        super().__init__(
            {
                "taken": In(1),
                "writing": In(1),
                "update": In(1),
                "rewinds": In(1),
                "begin": In(1).array(parts),
                "passes": In(1),
                "ahead": Out(config.index_bits),
                "advance": Out(1).array(parts),
                "step": Out(1),
                "primes": Out(1),
                "primed": Out(1),
                "peeking": Out(1),
                **(peeks if self.peeks else {}),
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
