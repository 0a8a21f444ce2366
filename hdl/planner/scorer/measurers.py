"""Measures of a path: lengths of segments, angles of turns."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Kind, Schedule, Timed, slot_after
from pathgene.hdl.planner.scorer.widths import Widths
from pathgene.hdl.primitives.arithmetic import Divider, SquareRoot, WideMultiplier
from pathgene.hdl.primitives.unit import Choice, InstanceOf, Unit
from pathgene.hdl.protocol.planner import RADIUS_BITS, SCALE_FRACTION, SHARPEST_BITS, TURN_FRACTION


__all__ = ["SegmentMeasurer", "TurnMeasurer", "place_layout"]


def place_layout(widths: Widths) -> data.StructLayout:
    """Return the layout of a point's place: ``x``, ``y``, and the ``altitude`` in parts."""
    return data.StructLayout({"x": widths.position, "y": widths.position, "altitude": widths.part})


class SegmentMeasurer(Unit):
    """Measures the segment from the previous point to each point.

    A place is taken in every slot in which ``valid`` is set; all other slots are ignored. The
    result at the first point of a path does not belong to a segment.

    Source: step 1 of the score in ``docs/chip_planner.md``.

    Attributes
    ----------
    latency : int
        Cycles from a place's slot to its segment's slot.

    Members
    -------
    phase : In(1)
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
    point_cycles: Choice(1, 2, text="Cycles of a slot.")

    def interface(self):
        widths = self.widths
        self.root = SquareRoot(widths.length)
        self.square = WideMultiplier(signed(widths.side), signed(widths.side))
        scale = SCALE_FRACTION + 1
        self.scaled = WideMultiplier(signed(widths.side), scale)
        products = self.scaled.latency + self.square.latency
        latency = 2 + self.point_cycles + products + self.root.latency
        self.latency = slot_after(latency, self.point_cycles)
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

        stages = Schedule(m, self.phase, self.point_cycles)
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
        """Return a scaled difference, with halves rounded away from 0."""
        half = 1 << SCALE_FRACTION - 1
        side = product + Mux(product < 0, half - 1, half) >> SCALE_FRACTION
        return side[: self.widths.side].as_signed()


class TurnMeasurer(Unit):
    """Measures the turn from each segment's predecessor into the segment.

    A segment is taken in every slot in which ``valid`` is set; all other slots are ignored. The
    first two slots of a path have no turn and a tangent length of 0, because the first point has no
    segment and the second has no previous one.

    Source: step 2 of the score in ``docs/chip_planner.md``.

    Attributes
    ----------
    latency : int
        Cycles from a segment's slot to its turn's slot.

    Members
    -------
    phase : In(1)
    valid : In(1)
    first : In(1)
        The slot contains a path's first point.
    dx, dy : In(signed(widths.side))
    length : In(widths.length)
    radius : In(RADIUS_BITS)
    half_turn : Out(widths.half_turn)
        Tangent of half the turn, rounded up; undefined if no segment has room for the arc.
    tangent : Out(widths.tangent)
        Tangent length, with the highest bit set if no segment has room for it.
    """

    widths: InstanceOf(Widths)
    point_cycles: Choice(1, 2, text="Cycles of a slot.")

    def interface(self):
        widths = self.widths
        side = signed(widths.side)
        self.cross = WideMultiplier(side, side)
        self.dot = WideMultiplier(side, side)
        self.lengths = WideMultiplier(widths.length, widths.length)
        # The divisor consists of two products of vectors.
        self.divider = Divider(widths.cross + 1, SHARPEST_BITS + TURN_FRACTION)
        self.tangents = WideMultiplier(RADIUS_BITS, widths.half_turn)
        products = self.cross.latency + self.tangents.latency
        latency = 5 + self.point_cycles + products + self.divider.latency
        self.latency = slot_after(latency, self.point_cycles)
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

        stages = Schedule(m, self.phase, self.point_cycles)
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
        """Return the tangent of half the turn, and the tangent length, as held values."""
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
