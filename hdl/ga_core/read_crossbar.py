"""The read ports of the population: each passes the waypoints of one slot."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.arguments import check_integer
from pathgene.hdl.primitives.multiplexer import one_hot_multiplex_tree


__all__ = ["ReadCrossbar"]

_PORTS_OF_PART = 3


class ReadCrossbar(wiring.Component):
    """One register per port, with a multiplexer of all slots: the largest unit of the chip.

    A port registers its choice too, since that reaches the whole multiplexer.

    Parameters
    ----------
    ports : int
        Ports, 1 or more.
    population : int
        Slots, 2 or more.
    waypoint_bits : int
        Width of a waypoint.

    Members
    -------
    selects : In(population).array(ports)
        The slot of each port, decoded: at most one bit is set. It takes effect in the next cycle.
    slots : In(waypoint_bits).array(population)
        Present waypoint of each slot.
    step : In(1)
        The first port takes its waypoint. The others do so in every cycle.
    writing : In(1).array(parts_of(ports))
        All ports take ``written`` instead. All are equal; each drives some of the ports. Overrides
        ``step``.
    written : In(waypoint_bits)
    waypoints : Out(waypoint_bits).array(ports)
        Waypoint that each port took in the cycle before; the first port, at its latest ``step``.

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    @staticmethod
    def parts_of(ports: int) -> int:
        """Return the number of parts into which the ports are divided for ``writing``."""
        return -(-ports // _PORTS_OF_PART)

    def __init__(self, *, ports, population, waypoint_bits):
        check_integer("Ports", ports, 1)
        check_integer("Population", population, 2)
        check_integer("Waypoint width", waypoint_bits, 1)

        self.ports = ports
        self.population = population
        self.waypoint_bits = waypoint_bits
        super().__init__(
            {
                "selects": In(population).array(ports),
                "slots": In(waypoint_bits).array(population),
                "step": In(1),
                "writing": In(1).array(self.parts_of(ports)),
                "written": In(waypoint_bits),
                "waypoints": Out(waypoint_bits).array(ports),
            }
        )

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
