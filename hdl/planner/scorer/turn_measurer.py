"""Tangent of half the turn between two segments, and the tangent length of its arc."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Kind, Schedule, Timed
from pathgene.hdl.planner.scorer.widths import Widths
from pathgene.hdl.primitives.divider import Divider
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.primitives.wide_multiplier import WideMultiplier
from pathgene.hdl.protocol.planner import RADIUS_BITS, SHARPEST_BITS, TURN_FRACTION


__all__ = ["TurnMeasurer"]


class TurnMeasurer(Unit):
    """Measures the turn from each segment's predecessor into the segment.

    A segment is taken in every slot in which ``valid`` is set; other slots do not count. The first
    two slots of a path have no turn, and a tangent length of 0: the first point has no segment, and
    the second none before it.

    Source: step 2 of the score in ``docs/chip_planner.md``.

    Attributes
    ----------
    latency : int
        Cycles from a segment's slot to its turn's.

    Members
    -------
    phase : In(1)
        1 in the second cycle of every slot.
    valid : In(1)
    first : In(1)
        The slot holds a path's first point.
    dx, dy : In(signed(widths.side))
    length : In(widths.length)
    radius : In(RADIUS_BITS)
    half_turn : Out(widths.half_turn)
        Tangent of half the turn, rounded up; undefined where no segment has room for the arc.
    tangent : Out(widths.tangent)
        Length; with the highest bit set where no segment has room for it.
    """

    widths: InstanceOf(Widths)

    def interface(self):
        widths = self.widths
        side = signed(widths.side)
        self.cross = WideMultiplier(side, side)
        self.dot = WideMultiplier(side, side)
        self.lengths = WideMultiplier(widths.length, widths.length)
        # Two products of vectors make the divisor.
        self.divider = Divider(widths.cross + 1, SHARPEST_BITS + TURN_FRACTION)
        self.tangents = WideMultiplier(RADIUS_BITS, widths.half_turn)
        latency = 7 + self.cross.latency + self.divider.latency + self.tangents.latency
        self.latency = (latency | 1) + 1
        return {
            "phase": In(1),
            "valid": In(1),
            "first": In(1),
            "dx": In(side),
            "dy": In(side),
            "length": In(widths.length),
            "radius": In(RADIUS_BITS),
            "half_turn": Out(widths.half_turn),
            "tangent": Out(widths.tangent),
        }

    def elaborate(self, platform):
        m = Module()

        stages = Schedule(m, self.phase)
        names = ("dx", "dy", "length", "first")
        now = {name: getattr(self, name) for name in names}
        then = {
            name: Signal.like(now[name], name=f"{name}_before", reset_less=True) for name in names
        }
        with m.If(self.phase & self.valid):
            m.d.sync += [then[name].eq(now[name]) for name in names]

        now, then = ({name: Timed(each[name], 0) for name in names} for each in (now, then))
        before = stages.alternate("side_before", then["dx"], then["dy"])
        same = stages.alternate("same_side", now["dx"], now["dy"])
        other = stages.alternate("other_side", now["dy"], now["dx"])
        crosses = stages.through("cross", self.cross, "product", first=before, second=other)
        dots = stages.through("dot", self.dot, "product", first=before, second=same)
        lengths = stages.through(
            "lengths", self.lengths, "product", first=then["length"], second=now["length"]
        )
        twist = stages.compute("twist", lambda one, two: one - two, *stages.apart(crosses))
        cross = stages.compute(
            "cross_size",
            lambda twist: Mux(twist < 0, -twist, twist)[: self.widths.cross],
            twist,
        )
        dot = stages.compute("dot_sum", lambda x, y: x + y, *stages.apart(dots))
        along = stages.compute("along", lambda dot, lengths: dot + lengths, dot, lengths)
        turns = stages.compute(
            "turning", lambda first, before: ~first & ~before, now["first"], then["first"]
        )
        half_turn, tangent = self._divide(stages, cross, along, turns)
        assert half_turn.time == tangent.time == self.latency
        m.d.comb += [self.half_turn.eq(half_turn.value), self.tangent.eq(tangent.value)]

        return m

    def _divide(self, stages, cross, along, turns):
        """Return the tangent of half the turn, and the tangent length, held."""
        # Only a divisor above 0 is greater than this.
        sharp = stages.compute(
            "sharp", lambda cross, along: (cross >> SHARPEST_BITS) >= along, cross, along
        )
        straight = stages.compute("straight", lambda cross: cross == 0, cross)
        shifted = Timed(cross.value << TURN_FRACTION, cross.time, Kind.SINGLE)
        quotient = stages.through(
            "divider", self.divider, "quotient", dividend=shifted, divisor=along
        )
        half_turn = stages.compute(
            "half_turn_up",
            lambda quotient, straight: Mux(straight, 0, quotient + 1),
            quotient,
            straight,
        )
        radius = Timed(self.radius, 0, Kind.STEADY)
        product = stages.through(
            "tangents", self.tangents, "product", first=radius, second=half_turn
        )
        length = stages.compute(
            "tangent_up",
            lambda product: product + (1 << TURN_FRACTION) - 1 >> TURN_FRACTION,
            product,
        )
        limit = self.widths.length
        tangent = stages.compute(
            "tangent_short",
            lambda length, sharp, turns: Mux(
                turns, Cat(length[:limit], sharp | length[limit:].any()), 0
            ),
            length,
            sharp,
            turns,
        )
        (half_turn,) = stages.together(self.latency, stages.hold("half_turn_held", half_turn))
        return half_turn, stages.hold("tangent_held", tangent)
