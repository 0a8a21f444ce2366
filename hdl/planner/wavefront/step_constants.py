"""Constants of the wavefront's steps."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.planner.wavefront.layouts import step_constants_layout
from hdl.planner.wavefront.widths import FAR, distance_bits
from hdl.primitives.arguments import check_integer
from hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    POSITION_FRACTION,
    SCALE_FRACTION,
    SLOPE_BITS,
    SLOPE_FRACTION,
)


__all__ = ["StepConstants"]

#: Width of a limit of slopes.
LIMIT_BITS = 4
#: Bits of the second factor of every product, one for each cycle.
_FACTOR_BITS = 16
_PRODUCTS = 16


class StepConstants(wiring.Component):
    """Distances, falls and factors of costs between blocks, one after another.

    One adder makes all products, a bit of a factor in a cycle; another one the root meanwhile.
    ``done`` follows :attr:`cycles` cycles after ``launch``. Equals what
    :mod:`sim.model.planner.definition.wavefront` has of ``distances`` and ``falls``.

    Parameters
    ----------
    problem_layout : StructLayout
        Layout of the problem: see :func:`hdl.planner.layouts.problem_layout`.
    coordinate_bits : int
        Width of a coordinate of the map, 1 or more.

    Attributes
    ----------
    cycles : int
        Cycles from ``launch`` to the first one of ``done``.

    Members
    -------
    problem : In(problem_layout)
        Steady.
    limit : In(4)
        Slope limit of the surface, in halves of the climb limit. Steady.
    launch : In(1)
        Pulse.
    done : Out(1)
        The constants are those of the latest ``launch``.
    constants : Out(step_constants_layout)

    Raises
    ------
    TypeError, ValueError
        If the width is not an integer, or less than 1.
    """

    def __init__(self, problem_layout, coordinate_bits):
        check_integer("Coordinate width", coordinate_bits, 1)

        self.problem_layout = problem_layout
        self.coordinate_bits = coordinate_bits
        self.constants_layout = step_constants_layout(coordinate_bits)
        self.cycles = 3 + _PRODUCTS * (_FACTOR_BITS + 2)
        super().__init__(
            {
                "problem": In(self.problem_layout),
                "limit": In(LIMIT_BITS),
                "launch": In(1),
                "done": Out(1),
                "constants": Out(self.constants_layout),
            }
        )

    def elaborate(self, platform):
        m = Module()

        problem = self.problem
        constants = Signal(self.constants_layout, reset_less=True)
        m.d.comb += self.constants.eq(constants)
        ways = constants.ways
        width = distance_bits(self.coordinate_bits)

        # Products in their order: two factors, then what becomes of the product.
        weight = Signal(len(problem.drag) + len(problem.fuel), reset_less=True)
        slope = Signal(SLOPE_BITS + width, reset_less=True)
        squares = Signal(2 * width, reset_less=True)
        product = Signal(signed(len(slope) + LIMIT_BITS + 2), reset_less=True)
        fall = product.as_unsigned()[SLOPE_FRACTION + ALTITUDE_FRACTION + 1 :]
        steps = [
            (ways[0].distance, ways[0].distance, squares.eq(product)),
            (ways[1].distance, ways[1].distance, squares.eq(squares + product)),
            (problem.rise, problem.fuel, constants.climb.eq(product)),
            (problem.drag, problem.fuel, weight.eq(product)),
        ]
        for way in ways:
            steps += [
                (problem.climb, way.distance, slope.eq(product)),
                (slope, self.limit, way.fall.eq(Mux(fall > FAR, FAR, fall))),
                (weight, way.distance, way.pull.eq(product)),
                (problem.base, way.distance, way.level.eq(product)),
            ]
        assert len(steps) == _PRODUCTS
        assert all(len(factor) <= _FACTOR_BITS for _, factor, _ in steps)

        busy = Signal()
        opening = Signal(2)
        number = Signal(range(_PRODUCTS))
        bit = Signal(range(_FACTOR_BITS + 2))
        adds = Signal(signed(len(slope) + 1), reset_less=True)
        left = Signal(_FACTOR_BITS, reset_less=True)
        m.d.comb += self.done.eq(~busy)

        # Sides of a block, halves rounded up.
        below = SCALE_FRACTION - POSITION_FRACTION
        sides = []
        for axis, way in zip("xy", ways, strict=False):
            side = Signal(width + below, name=f"side_{axis}", reset_less=True)
            m.d.sync += side.eq(problem[f"{axis}_scale"] << problem.block_shift)
            sides.append(way.distance.eq((side + (1 << below - 1)) >> below))

        root_begins = Signal()
        with m.If(opening.any()):
            m.d.sync += [opening.eq(opening << 1), bit.eq(0), number.eq(0), *sides]
        with m.Elif(busy):
            m.d.sync += [
                bit.eq(bit + 1),
                product.eq((product << 1) + Mux(left[-1], adds, 0)),
                left.eq(left << 1),
            ]
            with m.If(bit == 0):
                m.d.sync += product.eq(0)
                with m.Switch(number):
                    for i, (first, second, _) in enumerate(steps):
                        with m.Case(i):
                            m.d.sync += [adds.eq(first), left.eq(second)]
            with m.If(bit == _FACTOR_BITS + 1):
                m.d.sync += [bit.eq(0), number.eq(number + 1), busy.eq(number != _PRODUCTS - 1)]
                m.d.comb += root_begins.eq(number == 1)
                with m.Switch(number):
                    for i, (_, _, use) in enumerate(steps):
                        with m.Case(i):
                            m.d.sync += use
        with m.If(self.launch):
            m.d.sync += [busy.eq(1), opening.eq(1)]

        # The root of the squares: a bit in a cycle, done before its first product.
        assert width + 2 < 2 * (_FACTOR_BITS + 2)
        left_digits = Signal(range(width + 1))
        rest = Signal(2 * width, reset_less=True)
        remainder = Signal(width + 2, reset_less=True)
        root_loads = Signal()
        m.d.sync += root_loads.eq(root_begins)
        diagonal = ways[2].distance
        raised = Cat(rest[-2:], remainder)
        beyond = Signal(signed(len(raised) + 1))
        m.d.comb += beyond.eq(raised - Cat(C(1, 2), diagonal))
        with m.If(root_loads):
            m.d.sync += [
                rest.eq(squares),
                remainder.eq(0),
                diagonal.eq(0),
                left_digits.eq(width),
            ]
        with m.Elif(left_digits.any()):
            m.d.sync += [
                left_digits.eq(left_digits - 1),
                rest.eq(rest << 2),
                remainder.eq(Mux(beyond < 0, raised, beyond)),
                diagonal.eq(Cat(beyond >= 0, diagonal)),
            ]

        return m
