"""Penalty of a path: slopes beyond their limits, turns that are too sharp."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Kind, Schedule, Timed, slot_after
from pathgene.hdl.planner.scorer.widths import Widths
from pathgene.hdl.primitives.arithmetic import WideMultiplier
from pathgene.hdl.primitives.unit import Choice, Count, InstanceOf, Unit, Width
from pathgene.hdl.protocol.planner import (
    EXCESS_BITS,
    POSITION_FRACTION,
    SLOPE_BITS,
    SLOPE_FRACTION,
    STEEP,
    VALUE_BITS,
)


__all__ = ["PenaltyCounter", "SlopeComparator", "judged_layout"]


class SlopeComparator(Unit):
    """Determines whether a ``rise`` over a ``length`` is too steep, and the excess.

    Attributes
    ----------
    latency : int
        Cycles from a slot of lengths to the slot of its verdict.

    Members
    -------
    phase : In(1)
    length : In(length_bits)
    rise : In(signed(rise_bits))
    climb, descent : In(SLOPE_BITS)
        Limits of slopes upwards and downwards.
    steep : Out(1)
    excess : Out(rise_bits - fraction + EXCESS_BITS)
        Excess rise or fall of a steep slope, in quarters of a part, rounded down.
    """

    length_bits: Width(1)
    rise_bits: Width("fraction + 1", text="Its sign included.")
    fraction: Count(0, text="Bits of the rise below the part.")
    point_cycles: Choice(1, 2, text="Cycles of a slot.")

    def interface(self):
        self.grade = WideMultiplier(self.length_bits, SLOPE_BITS)
        self.latency = slot_after(3 + self.grade.latency, self.point_cycles)
        return {
            "phase": In(1),
            "length": In(self.length_bits),
            "rise": In(signed(self.rise_bits)),
            "climb": In(SLOPE_BITS),
            "descent": In(SLOPE_BITS),
            "steep": Out(1),
            "excess": Out(self.rise_bits - self.fraction + EXCESS_BITS),
        }

    def elaborate(self, platform):
        m = Module()

        stages = Schedule(m, self.phase, self.point_cycles)
        length, rise = Timed(self.length, 0), Timed(self.rise, 0)
        climb, descent = (Timed(each, 0, Kind.STEADY) for each in (self.climb, self.descent))
        length = stages.compute("run", lambda length: length, length)
        limit = stages.compute(
            "limit",
            lambda rise, climb, descent: Mux(rise < 0, descent, climb),
            rise,
            climb,
            descent,
        )
        size = stages.compute(
            "size", lambda rise: Mux(rise < 0, -rise, rise)[: self.rise_bits], rise
        )
        product = stages.through("grade", self.grade, "product", first=length, second=limit)
        # Both sides have the same number of bits below the part; no rise reaches the bits above.
        fraction = max(self.fraction, SLOPE_FRACTION)
        top = self.rise_bits - 1 + fraction - self.fraction + 1
        grade = Timed(product.value << fraction - SLOPE_FRACTION, product.time, product.kind)
        gentle = stages.compute("gentle", lambda grade: grade[top:].any(), grade)
        difference = stages.compute(
            "difference",
            lambda size, grade: ((size << fraction - self.fraction) - grade[:top])[: top + 1],
            size,
            grade,
        )
        steep = stages.compute(
            "steep_now",
            lambda difference, gentle: ~gentle & ~difference[top] & difference.any(),
            difference,
            gentle,
        )
        kept = difference.value[fraction - EXCESS_BITS : top]
        excess = stages.hold("excess_held", Timed(kept, difference.time, difference.kind))
        steep = stages.hold("steep_held", steep)
        assert steep.time == self.latency
        m.d.comb += [self.steep.eq(steep.value), self.excess.eq(stages.at(excess, self.latency))]

        return m


#: A length of one cell: the minimum that counts for a steep arc.
_CELL = 1 << POSITION_FRACTION

#: A missing arc counts as an eighth of the path.
_SHARE_SHIFT = 3


def judged_layout(widths: Widths) -> data.StructLayout:
    """Return the layout of a segment and the arc at its end, with their faults.

    ``first``, ``last`` (segment of its path), ``steep`` (the segment is too steep), ``excess`` (of
    a steep segment), ``sharp`` (the arc does not fit), ``steep_arc`` (the arc is too steep),
    ``length``, ``arc_length``.
    """
    return data.StructLayout(
        {
            "first": 1,
            "last": 1,
            "steep": 1,
            "excess": widths.excess,
            "sharp": 1,
            "steep_arc": 1,
            "length": widths.length,
            "arc_length": widths.arc,
        }
    )


class PenaltyCounter(Unit):
    """Adds up a path's penalty.

    It is the sum of a quarter of a cell plus the excess for each steep segment, an eighth of the
    path for each missing arc, and the length of each steep arc, but at least one cell.

    Source: step 5 of the score in ``docs/chip_planner.md``.

    Attributes
    ----------
    latency : int
        Cycles from the slot of a path's last segment to the slot of its penalty.

    Members
    -------
    phase : In(1)
    valid : In(1)
    judged : In(judged_layout)
    penalty : Out(VALUE_BITS)
        Saturates at its maximum value.
    """

    widths: InstanceOf(Widths)
    point_cycles: Choice(1, 2, text="Cycles of a slot.")

    def interface(self):
        widths = self.widths
        self.sharp = WideMultiplier(widths.total, widths.count, _SHARE_SHIFT)
        # Sums for a slot, then a product, two sums and a limit.
        latency = self.point_cycles + 3 + self.sharp.latency
        self.latency = slot_after(latency, self.point_cycles)
        return {
            "phase": In(1),
            "valid": In(1),
            "judged": In(judged_layout(widths)),
            "penalty": Out(VALUE_BITS),
        }

    def elaborate(self, platform):
        m = Module()

        judged, widths = self.judged, self.widths
        stages = Schedule(m, self.phase, self.point_cycles)
        added = {
            "total": (widths.total, judged.length),
            "steep": (widths.steep, Mux(judged.steep, judged.excess + STEEP, 0)),
            "sharp": (widths.count, judged.sharp),
            "steep_arcs": (
                widths.steep_arcs,
                Mux(judged.steep_arc, _at_least_a_cell(judged.arc_length), 0),
            ),
        }
        sums = {}
        for name, (width, value) in added.items():
            total = Signal(width, name=f"{name}_sum", reset_less=True)
            with m.If(self.phase & self.valid):
                m.d.sync += total.eq(Mux(judged.first, 0, total) + value)
            sums[name] = Timed(total, self.point_cycles)

        product = stages.through(
            "sharp", self.sharp, "product", first=sums["total"], second=sums["sharp"]
        )
        penalty = stages.compute(
            "steep_or_sharp", lambda product, steep: product + steep, product, sums["steep"]
        )
        whole = stages.compute(
            "whole", lambda penalty, arcs: penalty + arcs, penalty, sums["steep_arcs"]
        )
        limit = (1 << VALUE_BITS) - 1
        ended = stages.compute(
            "ended",
            lambda whole: Mux(whole[VALUE_BITS:].any(), limit, whole[:VALUE_BITS]),
            whole,
        )
        penalty = stages.hold("penalty_held", ended)
        assert penalty.time == self.latency
        m.d.comb += self.penalty.eq(penalty.value)

        return m


def _at_least_a_cell(length):
    """Return a length, or one cell if the length is shorter."""
    return Mux(length[POSITION_FRACTION:].any(), length, _CELL)
