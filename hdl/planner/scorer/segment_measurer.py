"""Sides, length and rise of a segment."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Schedule, Timed
from pathgene.hdl.planner.scorer.widths import Widths
from pathgene.hdl.primitives.square_root import SquareRoot
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.primitives.wide_multiplier import WideMultiplier
from pathgene.hdl.protocol.planner import SCALE_FRACTION


__all__ = ["SegmentMeasurer", "place_layout"]


def place_layout(widths: Widths) -> data.StructLayout:
    """Return the layout of a point's place: ``x``, ``y``, and the ``altitude`` in parts."""
    return data.StructLayout({"x": widths.position, "y": widths.position, "altitude": widths.part})


class SegmentMeasurer(Unit):
    """Measures the segment from the previous point to each point.

    A place is taken in every slot in which ``valid`` is set; other slots do not count. The result
    at the first point of a path does not belong to a segment.

    Source: step 1 of the score in ``docs/chip_planner.md``.

    Attributes
    ----------
    latency : int
        Cycles from a place's slot to its segment's.

    Members
    -------
    phase : In(1)
        1 in the second cycle of every slot.
    valid : In(1)
    place : In(place_layout)
    x_scale, y_scale : In(SCALE_FRACTION + 1)
        At most 1.
    dx, dy : Out(signed(widths.side))
        Sides of the segment.
    length : Out(widths.length)
    rise : Out(signed(widths.part + 1))
    """

    widths: InstanceOf(Widths)

    def interface(self):
        widths = self.widths
        self.root = SquareRoot(widths.length)
        self.square = WideMultiplier(signed(widths.side), signed(widths.side))
        scale = SCALE_FRACTION + 1
        self.scaled = WideMultiplier(signed(widths.side), scale)
        latency = 4 + self.scaled.latency + self.square.latency + self.root.latency
        self.latency = (latency | 1) + 1
        return {
            "phase": In(1),
            "valid": In(1),
            "place": In(place_layout(widths)),
            "x_scale": In(scale),
            "y_scale": In(scale),
            "dx": Out(signed(widths.side)),
            "dy": Out(signed(widths.side)),
            "length": Out(widths.length),
            "rise": Out(signed(widths.part + 1)),
        }

    def elaborate(self, platform):
        m = Module()

        stages = Schedule(m, self.phase)
        place = self.place
        before = Signal(place_layout(self.widths), reset_less=True)
        with m.If(self.phase & self.valid):
            m.d.sync += before.eq(place)

        now, then = (
            [Timed(each[axis], 0) for axis in ("x", "y", "altitude")] for each in (place, before)
        )
        ends = [stages.mux(now[0], now[1]), stages.mux(then[0], then[1])]
        difference = stages.compute("difference", lambda stop, start: stop - start, *ends)
        scale = stages.alternate("scale", Timed(self.x_scale, 0), Timed(self.y_scale, 0))
        product = stages.through("scaled", self.scaled, "product", first=difference, second=scale)
        side = stages.compute("side", self._rounded, product)
        square = stages.through("square", self.square, "product", first=side, second=side)
        radicand = stages.compute(
            "radicand", lambda x, y: (x + y)[: 2 * self.widths.length], *stages.apart(square)
        )
        root = stages.through("root", self.root, "root", radicand=radicand)
        length = stages.hold("length_held", root)
        assert length.time == self.latency

        dx, dy = map(stages.hold, ("dx_held", "dy_held"), stages.apart(side))
        rise = stages.compute_held("rise_held", lambda stop, start: stop - start, now[2], then[2])
        dx, dy, rise = stages.together(self.latency, dx, dy, rise)
        m.d.comb += [
            self.dx.eq(dx.value),
            self.dy.eq(dy.value),
            self.rise.eq(rise.value),
            self.length.eq(length.value),
        ]

        return m

    def _rounded(self, product):
        """Return a scaled difference, halves away from 0."""
        half = 1 << SCALE_FRACTION - 1
        side = product + Mux(product < 0, half - 1, half) >> SCALE_FRACTION
        return side[: self.widths.side].as_signed()
