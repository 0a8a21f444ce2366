"""The read ports of the population: each passes the waypoints of one slot."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.multiplexer import one_hot_multiplex_tree
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["ReadCrossbar"]

_PORTS_OF_PART = 3


class ReadCrossbar(Unit):
    """One register per port, with a multiplexer of all slots: the largest unit of the chip.

    A port registers its choice too, since that reaches the whole multiplexer.

    Members
    -------
    selects : In(population).array(ports)
        The slot of each port, decoded: at most one bit is set. It takes effect in the next cycle.
    slots : In(waypoint_bits).array(population)
        Present waypoint of each slot.
    step : In(1)
        The first port takes its waypoint. All other ports do so in every cycle.
    writing : In(1).array(parts_of(ports))
        All ports take ``written`` instead. All are equal; each drives some of the ports. Overrides
        ``step``.
    written : In(waypoint_bits)
    waypoints : Out(waypoint_bits).array(ports)
        Waypoint that each port took in the previous cycle; the first port, at its latest ``step``.
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
            # Outside a condition, which would be one more input of every look-up table.
            passing = one_hot_multiplex_tree(m, chosen, self.slots, f"of_slots_{number}")
            m.d.comb += waypoint.eq(port)
            with m.If(self.writing[number // _PORTS_OF_PART]):
                m.d.sync += port.eq(self.written)
            with m.Elif(self.step if number == 0 else C(1)):
                m.d.sync += port.eq(passing)

        return m
