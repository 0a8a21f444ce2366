"""The ports of the population: each lets the waypoints of one slot pass."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config
from hdl.ga_core.slot_mapping import carriers
from hdl.primitives.multiplexer import one_hot_multiplex_tree


__all__ = ["ReadCrossbar"]

_PORTS_OF_PART = 3


class ReadCrossbar(wiring.Component):
    """Registers, each with a choice of all slots: the largest part of the chip by far.

    What chooses has to reach all of it, so that it comes from a register of each port.

    Parameters
    ----------
    config : Config

    Members
    -------
    selects : In(population).array(carriers)
        The slot of each port, decoded: at most one bit is set. What passes follows it a clock
        later.
    slots : In(waypoint_bits).array(population)
        Present waypoint of each slot.
    step : In(1)
        The first port takes its waypoint; the others do in every clock.
    writing : In(1).array(parts_of(config))
        All ports take ``written`` instead: equal, each for some of the ports. Stronger than
        ``step``.
    written : In(waypoint_bits)
    waypoints : Out(waypoint_bits).array(carriers)
        What each port took in the clock before, the first one at its latest ``step``.
    """

    @staticmethod
    def parts_of(config: Config) -> int:
        """Return the number of parts of the ports that are controlled by registers of their own."""
        return -(-carriers(config) // _PORTS_OF_PART)

    def __init__(self, config: Config):
        self.config = config
        super().__init__(
            {
                "selects": In(config.population).array(carriers(config)),
                "slots": In(config.waypoint_bits).array(config.population),
                "step": In(1),
                "writing": In(1).array(self.parts_of(config)),
                "written": In(config.waypoint_bits),
                "waypoints": Out(config.waypoint_bits).array(carriers(config)),
            }
        )

    def elaborate(self, platform):
        m = Module()

        for number, (select, waypoint) in enumerate(zip(self.selects, self.waypoints, strict=True)):
            chosen = Signal(len(select), name=f"select_{number}", reset_less=True)
            port = Signal(len(waypoint), name=f"port_{number}", reset_less=True)
            m.d.sync += chosen.eq(select)
            # Not within a condition, which would be an input more of every table.
            passing = one_hot_multiplex_tree(m, chosen, self.slots, f"of_slots_{number}")
            m.d.comb += waypoint.eq(port)
            with m.If(self.writing[number // _PORTS_OF_PART]):
                m.d.sync += port.eq(self.written)
            with m.Elif(self.step if number == 0 else C(1)):
                m.d.sync += port.eq(passing)

        return m
