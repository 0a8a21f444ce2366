"""Costs of steps between neighbouring blocks."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.wavefront.layouts import way_layout
from pathgene.hdl.planner.wavefront.widths import (
    CLIMB_SHIFT,
    COST_BITS,
    FACTOR_BITS,
    factor_fraction,
)
from pathgene.hdl.primitives.delay_line import delay_line
from pathgene.hdl.primitives.multiplier import Multiplier
from pathgene.hdl.primitives.unit import Unit, Width


__all__ = ["StepPricer"]


class StepPricer(Unit):
    """Cost of a step between two blocks in every cycle.

    ``cost`` follows :attr:`latency` cycles after the altitudes. Equals ``cost`` of
    :class:`pathgene.sim.model.planner.definition.wavefront.Prices`, or is 2**30 where no step
    leads.

    Altitude and fuel each take one product of 18 bits and one sum. No sum wraps: altitudes add less
    than 2**23, and the base, a climb and level flight less than 2**28 each.

    Members
    -------
    way : In(way_layout)
    climb : In(18)
        Constants, steady.
    before, after : In(altitude_bits)
        Altitudes of the block and of its neighbour.
    leads : In(1)
        There is a step between the blocks whose altitudes were given ``latency`` - 1 cycles ago.
    cost : Out(31)
        1 to 2**30. A register.
    """

    altitude_bits: Width(1)

    #: Cycles from altitudes to their cost.
    latency = 5

    def interface(self):
        return {
            "way": In(way_layout),
            "climb": In(FACTOR_BITS),
            "before": In(self.altitude_bits),
            "after": In(self.altitude_bits),
            "leads": In(1),
            "cost": Out(COST_BITS),
        }

    def elaborate(self, platform):
        m = Module()

        way, z = self.way, self.altitude_bits

        def register(value, name):
            return delay_line(m, value, 1, name)

        widths, fraction = (FACTOR_BITS, z + 1), factor_fraction(z)
        m.submodules.height = height = Multiplier(widths, fraction, (False, False))
        further = fraction - CLIMB_SHIFT
        m.submodules.lift = lift = Multiplier(widths, max(further, 0), (False, True))
        m.d.comb += [
            height.first.eq(way.factor),
            height.second.eq(register(self.after + self.before, "altitudes")),
            lift.first.eq(self.climb),
            lift.second.eq(register(self.after - self.before, "rise")),
        ]

        level = register(height.product + way.level, "level")
        burnt = register((lift.product << max(-further, 0)) + way.pull, "burnt")
        total = register(level + Mux(burnt < 0, 0, burnt.as_unsigned()[:-1]), "total")

        most = COST_BITS - 1
        negative, nothing = total[most:].any(), ~total.any()
        one = self.leads & (negative | nothing)
        rest = Mux(self.leads & ~negative, total[:most], 0)
        m.d.sync += self.cost.eq(Cat(rest | one, ~self.leads))

        return m
