"""Price of a path: the pieces of its segments and arcs, summed up."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Kind, Schedule, Timed, slot_after
from pathgene.hdl.planner.scorer.widths import Widths
from pathgene.hdl.primitives.arithmetic import SquareRoot, WideMultiplier
from pathgene.hdl.primitives.unit import Choice, InstanceOf, Unit
from pathgene.hdl.protocol.planner import (
    BASE_BITS,
    DRAG_FRACTION,
    FUEL_BITS,
    RISE_BITS,
    RISE_FRACTION,
    VALUE_BITS,
)


__all__ = ["PathPricer", "PiecePricer", "laid_layout"]


_SHIFT_BITS = 5


class PiecePricer(Unit):
    """Prices a piece per cycle: altitude times length, plus fuel if the engine must pull.

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
        # One bit more than the length's, for rounding.
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

        # There is a piece in every cycle; nothing depends on slots.
        stages = Schedule(m, Const(1), 1)
        before, after, length = (
            Timed(each, 0, Kind.SINGLE) for each in (self.before, self.after, self.length)
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


def laid_layout(widths: Widths) -> data.StructLayout:
    """Return the layout of a segment with the arc at its end.

    ``first``, ``last`` (segment of its path), ``length``, ``tangent`` (of the arc, 0 if there is
    none), ``arc_length``, ``start_altitude`` (of the point where the segment begins), ``before``
    and ``after`` (altitudes where the arc begins and ends, or of the waypoint if there is no arc).
    """
    return data.StructLayout(
        {
            "first": 1,
            "last": 1,
            "length": widths.length,
            "tangent": widths.length,
            "arc_length": widths.arc,
            "start_altitude": widths.part,
            "before": widths.part,
            "after": widths.part,
        }
    )


class PathPricer(Unit):
    """Adds up the costs of a path's pieces: its arcs, and the straight remainders of its segments.

    Attributes
    ----------
    latency : int
        Cycles from the slot of a path's last segment to the slot of its value.

    Members
    -------
    phase : In(1)
    valid : In(1)
    laid : In(laid_layout)
    rise : In(RISE_BITS)
    base : In(signed(BASE_BITS))
    drag : In(DRAG_FRACTION)
    fuel : In(FUEL_BITS)
    fuel_shift : In(5)
    key_shift : In(6)
        Fields of the record.
    value : Out(VALUE_BITS)
        The cost, shifted, from 0 to the maximum value.
    """

    widths: InstanceOf(Widths)
    point_cycles: Choice(1, 2, text="Cycles of a slot.")

    def interface(self):
        widths = self.widths
        self.pieces = PiecePricer(widths)
        # A register before the pieces and one for their sum, a slot for the sum of the path, and
        # six cycles for the value.
        both = slot_after(1 + self.point_cycles + self.pieces.latency, self.point_cycles)
        self.latency = both + self.point_cycles + slot_after(6, self.point_cycles)
        return {
            "phase": In(1),
            "valid": In(1),
            "laid": In(laid_layout(widths)),
            "rise": In(RISE_BITS),
            "base": In(signed(BASE_BITS)),
            "drag": In(DRAG_FRACTION),
            "fuel": In(FUEL_BITS),
            "fuel_shift": In(5),
            "key_shift": In(6),
            "value": Out(VALUE_BITS),
        }

    def elaborate(self, platform):
        m = Module()

        stages = Schedule(m, self.phase, self.point_cycles)
        laid = {name: Timed(self.laid[name], 0) for name, _ in self.laid.shape()}
        cost = self._price(m, stages, laid)
        straight, arc = stages.apart(cost)
        both = stages.compute(
            "both",
            lambda straight, arc, curves: straight + Mux(curves, arc, 0),
            straight,
            arc,
            Timed(self.laid.tangent.any(), 0),
        )
        both = stages.hold("both_held", both)

        total = Signal(signed(self.widths.cost), reset_less=True)
        first, valid = (
            stages.at(each, both.time) for each in (laid["first"], Timed(self.valid, 0))
        )
        with m.If(self.phase & valid):
            m.d.sync += total.eq(Mux(first, 0, total) + both.value)
        self._shift(m, stages, Timed(total, both.time + self.point_cycles))

        return m

    def _price(self, m, stages, laid):
        """Return the costs of segment and arc, a pair."""
        # Altitude at the end of the previous arc.
        altitude = Signal(self.widths.part, reset_less=True)
        taken = Signal(self.widths.length, reset_less=True)
        with m.If(self.phase & self.valid):
            m.d.sync += [altitude.eq(self.laid.after), taken.eq(self.laid.tangent)]

        begins, left = Signal(self.widths.part), Signal(self.widths.length)
        used = Mux(self.laid.first, 0, taken)
        m.d.comb += [
            begins.eq(Mux(self.laid.first, self.laid.start_altitude, altitude)),
            left.eq(self.laid.length - used - self.laid.tangent),
        ]
        before = stages.alternate("piece_before", Timed(begins, 0), laid["before"])
        after = stages.alternate("piece_after", laid["before"], laid["after"])
        length = stages.alternate("piece_length", Timed(left, 0), laid["arc_length"])
        fields = {
            name: Timed(getattr(self, name), 0, Kind.STEADY)
            for name in ("rise", "base", "drag", "fuel", "fuel_shift")
        }
        return stages.through(
            "pieces", self.pieces, "cost", before=before, after=after, length=length, **fields
        )

    def _shift(self, m, stages, total):
        """Add the stages from a path's cost to its value."""
        value = stages.compute("positive", lambda total: Mux(total < 0, 0, total)[:-1], total)
        beyond = Timed(C(0, 1), value.time, Kind.STEADY)
        shift = Timed(self.key_shift, 0, Kind.STEADY)
        for number, low in enumerate((4, 2, 0)):
            # Discard bits that no later stage can shift into the value.
            kept = VALUE_BITS + (1 << low) - 1
            shifted = stages.compute(
                f"shifted_{number}",
                lambda value, shift, low=low: value >> (shift[low : low + 2] << low),
                value,
                shift,
            )
            beyond = stages.compute(
                f"beyond_{number}",
                lambda value, before, kept=kept: before | value[kept:].any(),
                shifted,
                beyond,
            )
            value = Timed(shifted.value[:kept], shifted.time, Kind.SINGLE)
        value = stages.compute(
            "ended",
            lambda value, beyond: Mux(beyond, (1 << VALUE_BITS) - 1, value),
            value,
            beyond,
        )
        value = stages.hold("value_held", value)
        assert value.time == self.latency
        m.d.comb += self.value.eq(value.value)
