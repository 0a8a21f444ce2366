"""Counter of the waypoints that pass the ports during a crossover."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Count, Unit


__all__ = ["PositionCounter"]


class PositionCounter(Unit):
    """Counts positions until the longest path has passed.

    ``running`` and ``following`` lead the waypoints in the ports by a cycle. All outputs except
    ``goes_on`` are registers, since they reach the whole population.

    Members
    -------
    begin : In(1)
        Pulse, in the cycle before the first of the crossover. Never during a crossover.
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
        ``running`` and ``following`` of the cycle before: the ports hold those waypoints.
    done : Out(1)
        High in the cycle after the last of ``running``.
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
        # are combined. So `third` is three past `following`.
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
