"""Steps between neighbouring blocks: constants of a problem, and prices."""

import enum

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.wavefront.layouts import (
    CLIMB_SHIFT,
    COST_BITS,
    FACTOR_BITS,
    PART_BITS,
    distance_bits,
    factor_fraction,
    least_unit,
    step_constants_layout,
    way_layout,
)
from pathgene.hdl.primitives.arithmetic import Multiplier
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.unit import Given, Unit, Width
from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    POSITION_FRACTION,
    SCALE_FRACTION,
    SLOPE_FRACTION,
)


__all__ = ["StepConstants", "StepPricer"]


#: Width of a slope limit.
LIMIT_BITS = 4
#: Bits of the second factor of every product, one per cycle.
_FACTOR_BITS = 16
#: Shifts of a side of a block, which is rounded, and of a fall.
_SIDE_SHIFT = SCALE_FRACTION - POSITION_FRACTION
_FALL_SHIFT = SLOPE_FRACTION + ALTITUDE_FRACTION + 1


class _Kind(enum.IntEnum):
    """The products, in order."""

    SIDE = 0
    SQUARE = 1
    #: Drag and fuel; for falls, the slope.
    WEIGHT = 2
    PULL = 3
    #: Base and distance; for falls, slope and distance.
    LEVEL = 4
    FACTOR = 5
    #: Rise and fuel, then converted to the unit of a cost.
    LIFT = 6
    CLIMB = 7


#: Number of products of each kind.
_WAYS = {
    _Kind.SIDE: 2,
    _Kind.SQUARE: 2,
    _Kind.WEIGHT: 1,
    _Kind.PULL: 3,
    _Kind.LEVEL: 3,
    _Kind.FACTOR: 3,
    _Kind.LIFT: 1,
    _Kind.CLIMB: 1,
}


class StepConstants(Unit):
    """Constants of the costs of steps between blocks, or of their falls, one after another.

    One adder makes all products, one bit of a factor per cycle, lowest first; each additional cycle
    therefore shifts a product right. Meanwhile, a second adder makes the root. ``done`` follows
    :meth:`cycles` cycles after ``launch``. Equals ``prices_of`` of
    :mod:`pathgene.sim.model.planner.definition.wavefront`; with ``falls``, levels are the falls of
    ``limit_slopes``, except that a fall may be 0, and all other constants are 0.

    Attributes
    ----------
    most_cycles : int
        Maximum that :meth:`cycles` returns.

    Members
    -------
    problem : In(problem_layout)
        Steady from the cycle before ``launch`` on.
    limit : In(4)
        Slope limit of the surface, in halves of the climb limit. Steady.
    falls : In(1)
        Compute falls. Steady from ``launch`` to ``done``.
    launch : In(1)
        Pulse. Not before ``done``.
    done : Out(1)
        The constants of the latest ``launch`` are ready.
    constants : Out(step_constants_layout)
    """

    problem_layout: Given(
        "StructLayout",
        "Layout of the problem: see :func:`pathgene.hdl.planner.layouts.problem_layout`.",
    )
    coordinate_bits: Width(1)
    altitude_bits: Width(1)

    def interface(self):
        self.most_cycles = self.cycles(falls=False, fuel_shift=31, key_shift=63)
        return {
            "problem": In(self.problem_layout),
            "limit": In(LIMIT_BITS),
            "falls": In(1),
            "launch": In(1),
            "done": Out(1),
            "constants": Out(step_constants_layout),
        }

    def cycles(self, *, falls, fuel_shift, key_shift):
        """Return the cycles from ``launch`` to the first cycle of ``done``."""
        unit = max(key_shift, least_unit(self.coordinate_bits, self.altitude_bits))
        shifts = dict.fromkeys(_Kind, unit) | {
            _Kind.SIDE: _SIDE_SHIFT,
            _Kind.SQUARE: 0,
            _Kind.WEIGHT: 0 if falls else fuel_shift,
            _Kind.LIFT: fuel_shift,
            _Kind.CLIMB: unit + self._climb_scale()[1],
        }
        if falls:
            shifts[_Kind.LEVEL] = _FALL_SHIFT
        return 1 + sum(ways * (_FACTOR_BITS + 3 + shifts[kind]) for kind, ways in _WAYS.items())

    @property
    def _most_shift(self):
        return 63 + self._climb_scale()[1]

    def _climb_scale(self):
        """Return the second factor of the climb's last product, and its additional shift."""
        scale = ALTITUDE_FRACTION + factor_fraction(self.altitude_bits) - CLIMB_SHIFT
        return 1 << max(scale, 0), max(-scale, 0)

    def elaborate(self, platform):
        m = Module()

        constants = Signal(step_constants_layout, reset_less=True)
        m.d.comb += self.constants.eq(constants)

        width = distance_bits(self.coordinate_bits)
        sides = [Signal(width, name=f"side_{axis}", reset_less=True) for axis in "xy"]

        kind, way = Signal(range(len(_Kind))), Signal(range(3))
        # Both factors; the first one stays while its products follow. The product moves right
        # through both its registers, starting with the adder's.
        factor = Signal(signed(PART_BITS + 1), reset_less=True)
        left = Signal(_FACTOR_BITS, reset_less=True)
        high, low = Signal.like(factor, name="high"), Signal.like(left, name="low")
        product = Cat(low, high)
        total = Signal(signed(len(high) + 1))
        m.d.comb += total.eq(high + Mux(left[0], factor, 0))
        count = Signal(range(_FACTOR_BITS + self._most_shift))

        keeps, squares_end = Signal(), Signal()
        across = self._root(m, keeps & (kind == _Kind.SQUARE), squares_end, product)
        distance = Mux(way[1], across, Mux(way[0], sides[1], sides[0]))
        first, stays, second, shift = self._operands(m, kind, way, distance)

        with m.FSM() as states:
            with m.State("IDLE"):
                m.d.sync += [kind.eq(0), way.eq(0)]
                with m.If(self.launch):
                    m.next = "LOAD"
            with m.State("LOAD"):
                rounding = Mux(kind == _Kind.SIDE, 1 << _SIDE_SHIFT - 1, 0)
                with m.If(~stays):
                    m.d.sync += factor.eq(first)
                m.d.sync += [
                    left.eq(second),
                    high.eq(rounding),
                    count.eq(shift + _FACTOR_BITS - 1),
                ]
                m.next = "ADD"
            with m.State("ADD"):
                m.d.sync += [
                    Cat(low, high).eq(Cat(low[1:], total)),
                    left.eq(left >> 1),
                    count.eq(count - 1),
                ]
                with m.If(count == 0):
                    m.next = "CHECK"
            with m.State("CHECK"):
                m.next = "KEEP"
            with m.State("KEEP"):
                m.d.comb += keeps.eq(1)
                m.d.sync += way.eq(way + 1)
                m.next = "LOAD"
                with m.Switch(kind):
                    for each, ways in _WAYS.items():
                        with m.Case(each):
                            with m.If(way == ways - 1):
                                m.d.sync += [kind.eq(kind + 1), way.eq(0)]
                                if each == _Kind.SQUARE:
                                    m.d.comb += squares_end.eq(1)
                                if each == _Kind.CLIMB:
                                    m.next = "IDLE"
        m.d.comb += self.done.eq(states.ongoing("IDLE"))

        # Clamp products to the range of a part.
        negative, top = product[-1], product[PART_BITS:]
        beyond = delay_line(m, top.any() & ~top.all(), 1, "beyond")
        result = Mux(beyond, (~negative).replicate(PART_BITS), product[:PART_BITS])
        beyond_factor = delay_line(m, product[FACTOR_BITS:].any(), 1, "beyond_factor")

        def keep(register, value, of, number=0):
            with m.If(keeps & (kind == of) & (way == number)):
                m.d.sync += register.eq(value)

        for i, side in enumerate(sides):
            keep(side, result, _Kind.SIDE, i)
        keep(factor, result, _Kind.WEIGHT)
        keep(factor, result, _Kind.LIFT)
        climb = product[:FACTOR_BITS] | beyond_factor.replicate(FACTOR_BITS)
        keep(constants.climb, climb, _Kind.CLIMB)
        for i, each in enumerate(constants.ways):
            keep(each.pull, result, _Kind.PULL, i)
            keep(each.level, Cat(result, negative).as_signed(), _Kind.LEVEL, i)
            keep(each.factor, result, _Kind.FACTOR, i)

        return m

    def _operands(self, m, kind, way, distance):
        """Return the first factor of a product, whether it exists, the second, and the shift."""
        problem, z, falls = self.problem, self.altitude_bits, self.falls
        least = least_unit(self.coordinate_bits, z)
        # A register, because `problem` is shared with more units.
        unit = Signal(range(64), reset_less=True)
        m.d.sync += unit.eq(Mux(problem.key_shift > least, problem.key_shift, least))
        # With `falls`, unused constants become 0.
        wanted = Mux(falls, 0, distance)
        one = 1 << ALTITUDE_FRACTION + factor_fraction(z)
        climb_one, climb_further = self._climb_scale()
        table = {
            _Kind.SIDE: (
                1 << problem.block_shift,
                Mux(way[0], problem.y_scale, problem.x_scale),
                _SIDE_SHIFT,
            ),
            _Kind.SQUARE: (distance, distance, 0),
            _Kind.WEIGHT: (
                Mux(falls, problem.climb, problem.drag),
                Mux(falls, self.limit, problem.fuel),
                Mux(falls, 0, problem.fuel_shift),
            ),
            _Kind.PULL: (None, wanted, unit),
            _Kind.LEVEL: (problem.base, distance, Mux(falls, _FALL_SHIFT, unit)),
            _Kind.FACTOR: (Const(one), wanted, unit),
            _Kind.LIFT: (problem.rise, problem.fuel, problem.fuel_shift),
            _Kind.CLIMB: (None, Mux(falls, 0, climb_one), unit + climb_further),
        }
        first, stays = Signal(signed(PART_BITS + 1)), Signal()
        second, shift = Signal(_FACTOR_BITS), Signal(range(self._most_shift + 1))
        with m.Switch(kind):
            for each, (factor, *others) in table.items():
                with m.Case(each):
                    if factor is None:
                        m.d.comb += stays.eq(1)
                    else:
                        m.d.comb += first.eq(factor)
                    if each == _Kind.LEVEL:
                        m.d.comb += stays.eq(falls)
                    m.d.comb += [second.eq(others[0]), shift.eq(others[1])]
        return first, stays, second, shift

    def _root(self, m, adds, begins, product):
        """Return the root of the sum of two squares, one bit per cycle from the second cycle on."""
        width = distance_bits(self.coordinate_bits)
        # Within the first product after the squares.
        assert width <= _FACTOR_BITS
        left_digits = Signal(range(width + 1))
        rest = Signal(2 * width, reset_less=True)
        remainder = Signal(width + 2, reset_less=True)
        root = Signal(width, reset_less=True)
        raised = Cat(rest[-2:], remainder)
        beyond = Signal(signed(len(raised) + 1))
        m.d.comb += beyond.eq(raised - Cat(C(1, 2), root))
        with m.If(self.launch):
            m.d.sync += [rest.eq(0), remainder.eq(0), root.eq(0)]
        with m.Elif(adds):
            m.d.sync += rest.eq(rest + product)
        with m.If(begins):
            m.d.sync += left_digits.eq(width)
        with m.Elif(left_digits.any()):
            m.d.sync += [
                left_digits.eq(left_digits - 1),
                rest.eq(rest << 2),
                remainder.eq(Mux(beyond < 0, raised, beyond)),
                root.eq(Cat(beyond >= 0, root)),
            ]
        return root


class StepPricer(Unit):
    """Computes the cost of a step between two blocks in every cycle.

    ``cost`` follows :attr:`latency` cycles after the altitudes. Equals ``cost`` of
    :class:`pathgene.sim.model.planner.definition.wavefront.Prices`, or is 2**30 if there is no
    step.

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
