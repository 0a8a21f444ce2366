"""Cost of a straight piece or an arc."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Kind, Schedule, Timed
from pathgene.hdl.planner.scorer.widths import Widths
from pathgene.hdl.primitives.square_root import SquareRoot
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.primitives.wide_multiplier import WideMultiplier
from pathgene.hdl.protocol.planner import (
    BASE_BITS,
    DRAG_FRACTION,
    FUEL_BITS,
    RISE_BITS,
    RISE_FRACTION,
)


__all__ = ["PiecePricer"]

_SHIFT_BITS = 5


class PiecePricer(Unit):
    """Prices a piece in every cycle: altitude times length, and fuel where the engine must pull.

    Source: step 4 of the score in ``docs/chip_planner.md``.

    Attributes
    ----------
    latency : int
        Cycles from a piece to its cost.

    Members
    -------
    before, after : In(widths.part)
        Altitudes of the ends.
    length : In(widths.run)
    rise : In(RISE_BITS)
    base : In(signed(BASE_BITS))
    drag : In(DRAG_FRACTION)
    fuel : In(FUEL_BITS)
    fuel_shift : In(5)
    cost : Out(signed(widths.piece))
    """

    widths: InstanceOf(Widths)

    def interface(self):
        widths = self.widths
        up = signed(widths.part + 1 + RISE_BITS - RISE_FRACTION)
        self.climb = WideMultiplier(signed(widths.part + 1), RISE_BITS)
        self.up_square = WideMultiplier(up, up)
        self.length_square = WideMultiplier(widths.run, widths.run)
        # A bit more than the length's, for rounding.
        self.root = SquareRoot(widths.flown + 1)
        self.drag_pull = WideMultiplier(DRAG_FRACTION, widths.flown)
        self.burn = WideMultiplier(widths.pull, FUEL_BITS)
        self.height = WideMultiplier(signed(widths.level), widths.flown)
        squares = max(1 + self.climb.latency + self.up_square.latency, self.length_square.latency)
        flown = squares + 1 + self.root.latency + 1
        fuel = flown + self.drag_pull.latency + 2 + self.burn.latency + 3
        self.latency = max(fuel, flown + self.height.latency) + 1
        return {
            "before": In(widths.part),
            "after": In(widths.part),
            "length": In(widths.run),
            "rise": In(RISE_BITS),
            "base": In(signed(BASE_BITS)),
            "drag": In(DRAG_FRACTION),
            "fuel": In(FUEL_BITS),
            "fuel_shift": In(_SHIFT_BITS),
            "cost": Out(signed(widths.piece)),
        }

    def elaborate(self, platform):
        m = Module()

        # Every cycle has a piece; nothing depends on slots.
        stages = Schedule(m, Const(0))
        before, after, length = (
            Timed(each, 0, Kind.PAIR) for each in (self.before, self.after, self.length)
        )
        rise, base, drag, fuel, fuel_shift = (
            Timed(each, 0, Kind.STEADY)
            for each in (self.rise, self.base, self.drag, self.fuel, self.fuel_shift)
        )

        gain = stages.compute("gain", lambda before, after: after - before, before, after)
        climb = stages.through("climb", self.climb, "product", first=gain, second=rise)
        up = Timed(climb.value >> RISE_FRACTION, climb.time, climb.kind)
        squares = (
            stages.through("up_square", self.up_square, "product", first=up, second=up),
            stages.through(
                "length_square", self.length_square, "product", first=length, second=length
            ),
        )
        square = stages.compute(
            "square", lambda up, along: (up + along)[: 2 * self.widths.flown], *squares
        )
        radicand = Timed(Cat(C(0, 2), square.value), square.time, square.kind)
        root = stages.through("root", self.root, "root", radicand=radicand)
        flown = stages.compute("flown", lambda root: (root + 1 >> 1)[: self.widths.flown], root)

        resistance = stages.through(
            "drag_pull", self.drag_pull, "product", first=drag, second=flown
        )
        pull = stages.compute("pull", lambda drag, climb: drag + climb, resistance, climb)
        thrust = stages.compute(
            "thrust", lambda pull: Mux(pull < 0, 0, pull)[: self.widths.pull], pull
        )
        burnt = stages.through("burn", self.burn, "product", first=thrust, second=fuel)
        # Two bits of the shift in each stage.
        for low in range(0, _SHIFT_BITS, 2):
            burnt = stages.compute(
                f"burnt_{low}",
                lambda burnt, shift, low=low: burnt >> (shift[low : low + 2] << low),
                burnt,
                fuel_shift,
            )

        level = stages.compute("ends", lambda before, after: before + after, before, after)
        level = stages.compute(
            "level",
            lambda level, base: (level + base)[: self.widths.level].as_signed(),
            level,
            base,
        )
        height = stages.through("height", self.height, "product", first=level, second=flown)
        cost = stages.compute("cost_now", lambda height, burnt: height + burnt, height, burnt)
        assert cost.time == self.latency
        m.d.comb += self.cost.eq(cost.value)

        return m
