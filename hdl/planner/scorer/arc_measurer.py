"""Length of an arc, and its ends as shares of the two segments."""

from itertools import pairwise

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Kind, Schedule, Timed
from pathgene.hdl.planner.scorer.widths import TURN_BITS, Widths
from pathgene.hdl.primitives.divider import Divider
from pathgene.hdl.primitives.multiplexer import multiplex
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.primitives.wide_multiplier import WideMultiplier
from pathgene.hdl.protocol.planner import (
    MAX_HALF_TURN,
    RADIUS_BITS,
    SHARE_BITS,
    TURN_FRACTION,
    turn_table,
)


__all__ = ["ArcMeasurer"]

_TURNS = turn_table()
assert max(_TURNS).bit_length() == TURN_BITS
#: Bits of a tangent between two entries of the table.
_REST_BITS = 6
#: Maximum index for interpolation.
_LAST_TURN = MAX_HALF_TURN << TURN_FRACTION - _REST_BITS
_STEP_BITS = max(after - before for before, after in pairwise(_TURNS)).bit_length()


class ArcMeasurer(Unit):
    """Measures an arc in every slot.

    If the tangent length is 0 or the arc does not fit, the numbers are undefined.

    Source: step 3 of the score in ``docs/chip_planner.md``.

    Attributes
    ----------
    latency : int
        Cycles from a slot to the slot of its arc.

    Members
    -------
    phase : In(1)
        1 in the second cycle of every slot.
    half_turn : In(widths.half_turn)
    tangent : In(widths.length)
    length, next_length : In(widths.length)
        Lengths of the segments before and after the arc.
    radius : In(RADIUS_BITS)
    back, on : Out(widths.share)
        Tangent as shares of these segments.
    arc_length : Out(widths.arc)
    """

    widths: InstanceOf(Widths)

    def interface(self):
        widths = self.widths
        self.divider = Divider(widths.length, widths.share)
        self.step = WideMultiplier(_STEP_BITS, _REST_BITS, _REST_BITS)
        self.arc = WideMultiplier(RADIUS_BITS, TURN_BITS, TURN_FRACTION)
        shares = self.divider.latency + 1
        # Two registers before the table, two after it, and one after the sum.
        arc = 5 + self.step.latency + self.arc.latency
        self.latency = (max(shares, arc) | 1) + 1
        return {
            "phase": In(1),
            "half_turn": In(widths.half_turn),
            "tangent": In(widths.length),
            "length": In(widths.length),
            "next_length": In(widths.length),
            "radius": In(RADIUS_BITS),
            "back": Out(widths.share),
            "on": Out(widths.share),
            "arc_length": Out(widths.arc),
        }

    def elaborate(self, platform):
        m = Module()

        stages = Schedule(m, self.phase)
        divisor = stages.mux(Timed(self.length, 0), Timed(self.next_length, 0))
        dividend = Timed(self.tangent << SHARE_BITS, 0)
        shares = stages.through(
            "divider", self.divider, "quotient", dividend=dividend, divisor=divisor
        )
        back, on = (
            stages.hold(name, share)
            for name, share in zip(("back_held", "on_held"), stages.apart(shares), strict=True)
        )
        arc_length = self._measure(m, stages)
        outputs = {"back": back, "on": on, "arc_length": arc_length}
        for name, held in outputs.items():
            (value,) = stages.together(self.latency, held)
            m.d.comb += getattr(self, name).eq(value.value)

        return m

    def _measure(self, m, stages):
        """Return the length of the arc, held."""
        half_turn = Timed(self.half_turn, 0)
        # Sharper turns than the table's count as its sharpest.
        last = _LAST_TURN << _REST_BITS
        place = stages.compute_held(
            "place",
            lambda half: Mux(half >= last, last, half)[: last.bit_length()],
            half_turn,
        )
        rest = Timed(place.value[:_REST_BITS], place.time)
        index = stages.alternate(
            "index",
            Timed(place.value[_REST_BITS:], place.time),
            Timed((place.value[_REST_BITS:] + 1)[: _LAST_TURN.bit_length()], place.time),
        )
        entries = stages.compute(
            "entry", lambda index: multiplex(index, [C(turn, TURN_BITS) for turn in _TURNS]), index
        )
        low, high = stages.apart(entries)
        step = stages.compute("step", lambda low, high: (high - low)[:_STEP_BITS], low, high)
        product = stages.through("step_part", self.step, "product", first=step, second=rest)
        turn = stages.compute(
            "turn",
            lambda low, product: (low + product)[:TURN_BITS],
            low,
            product,
        )
        radius = Timed(self.radius, 0, Kind.STEADY)
        arc = stages.through("arc", self.arc, "product", first=radius, second=turn)
        return stages.hold("arc_held", arc)
