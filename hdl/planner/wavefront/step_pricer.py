"""Costs of steps between neighbouring blocks."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.planner.wavefront.layouts import way_layout
from hdl.planner.wavefront.widths import COST_BITS, FAR
from hdl.primitives.arguments import check_integer
from hdl.primitives.delay_line import delay_line
from hdl.primitives.wide_multiplier import WideMultiplier
from hdl.protocol.planner import ALTITUDE_FRACTION, FUEL_BITS, RISE_BITS


__all__ = ["StepPricer"]


class StepPricer(wiring.Component):
    """Cost of a step between two blocks in every cycle.

    ``cost`` follows :attr:`latency` cycles after the altitudes. Equals ``_step_cost`` of
    :mod:`sim.model.planner.definition.wavefront`, except that greater costs than 2**30 count as
    2**30: no block costs as much.

    The fuel's factor is multiplied into drag and rise beforehand, for it is never negative. So a
    step takes one wide product.

    Parameters
    ----------
    coordinate_bits, altitude_bits : int
        Widths of a coordinate of the map and of an altitude, 1 or more.

    Members
    -------
    way : In(way_layout)
    climb : In(36)
    fuel_shift, key_shift : In
        Constants, steady.
    before, after : In(altitude_bits)
        Altitudes of the block and of its neighbour.
    cost : Out(31)
        1 to 2**30. A register.

    Raises
    ------
    TypeError, ValueError
        If a width is not an integer, or less than 1.
    """

    #: Cycles from altitudes to their cost.
    latency = 12

    def __init__(self, coordinate_bits, altitude_bits):
        check_integer("Coordinate width", coordinate_bits, 1)
        check_integer("Altitude width", altitude_bits, 1)

        self.coordinate_bits = coordinate_bits
        self.altitude_bits = altitude_bits
        super().__init__(
            {
                "way": In(way_layout(coordinate_bits)),
                "climb": In(RISE_BITS + FUEL_BITS),
                "fuel_shift": In(5),
                "key_shift": In(6),
                "before": In(altitude_bits),
                "after": In(altitude_bits),
                "cost": Out(COST_BITS),
            }
        )

    def elaborate(self, platform):
        m = Module()

        way = self.way

        def register(value, name):
            return delay_line(m, value, 1, name)

        rise = register((self.after - self.before), "rise")
        total = register(self.after + self.before, "altitudes")

        # Fuel: two cycles of the product, one of its sum, two of its shift.
        m.submodules.lift = lift = WideMultiplier(len(self.climb), rise.shape())
        assert lift.latency == 2
        m.d.comb += [lift.first.eq(self.climb), lift.second.eq(rise)]
        burnt = register((lift.product << ALTITUDE_FRACTION) + way.pull, "burnt")
        burnt = Mux(burnt < 0, 0, burnt.as_unsigned()[:-1])
        burnt = register(burnt >> (self.fuel_shift[2:] << 2), "fuel_low")
        burnt = register(burnt >> self.fuel_shift[:2], "fuel")

        # Altitude: in time for the sum of both.
        m.submodules.height = height = WideMultiplier(len(way.distance), len(total))
        assert height.latency == 1
        m.d.comb += [height.first.eq(way.distance), height.second.eq(total)]
        level = register((height.product << ALTITUDE_FRACTION) + way.level, "height")
        level = delay_line(m, level, 3, "level")

        cost = register(level + burnt, "total")
        cost = Mux(cost < 0, 0, cost.as_unsigned()[:-1])
        cost = register(cost >> (self.key_shift[4:] << 4), "value_high")
        cost = register(cost >> (self.key_shift[2:4] << 2), "value_low")
        cost = register(cost >> self.key_shift[:2], "value")
        most = COST_BITS - 1
        beyond = register(cost[most:].any(), "beyond")
        nothing = register(~cost[:most].any(), "nothing")
        rest = register(cost[:most], "rest")
        m.d.sync += self.cost.eq(Mux(beyond, FAR, rest | nothing))

        return m
