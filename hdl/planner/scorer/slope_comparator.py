"""Comparison of a slope with its limits."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Kind, Schedule, Timed
from pathgene.hdl.primitives.unit import Count, Unit, Width
from pathgene.hdl.primitives.wide_multiplier import WideMultiplier
from pathgene.hdl.protocol.planner import EXCESS_BITS, SLOPE_BITS, SLOPE_FRACTION


__all__ = ["SlopeComparator"]


class SlopeComparator(Unit):
    """Tells whether a ``rise`` over a ``length`` is too steep, and by which excess.

    Attributes
    ----------
    latency : int
        Cycles from a slot of lengths to the slot of its verdict.

    Members
    -------
    phase : In(1)
        1 in the second cycle of every slot.
    length : In(length_bits)
    rise : In(signed(rise_bits))
    climb, descent : In(SLOPE_BITS)
        Limits of slopes upwards and downwards.
    steep : Out(1)
    excess : Out(rise_bits - fraction + EXCESS_BITS)
        Excess rise or fall of a slope that is too steep, in quarters of a part, rounded down.
    """

    length_bits: Width(1)
    rise_bits: Width("fraction + 1", text="Its sign included.")
    fraction: Count(0, text="Bits of the rise below the part.")

    def interface(self):
        self.grade = WideMultiplier(self.length_bits, SLOPE_BITS)
        self.latency = (3 + self.grade.latency | 1) + 1
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

        stages = Schedule(m, self.phase)
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
        # Both sides with as many bits below the part; no rise reaches the bits above.
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
