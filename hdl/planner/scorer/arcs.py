"""Arcs of a path: their lengths and shares, their ends."""

from itertools import pairwise

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Kind, Schedule, Timed, slot_after
from pathgene.hdl.planner.scorer.widths import TURN_BITS, Widths
from pathgene.hdl.primitives.arithmetic import Divider, WideMultiplier
from pathgene.hdl.primitives.logic import multiplex
from pathgene.hdl.primitives.unit import Choice, InstanceOf, Unit
from pathgene.hdl.protocol.planner import (
    ALTITUDE_FRACTION,
    MAX_HALF_TURN,
    RADIUS_BITS,
    SHARE_BITS,
    TURN_FRACTION,
    turn_table,
)


__all__ = ["ArcMeasurer", "ArcPlacer", "corner_layout"]


_TURNS = turn_table()
assert max(_TURNS).bit_length() == TURN_BITS
#: Number of tangent bits between two entries of the table.
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
    half_turn : In(widths.half_turn)
    tangent : In(widths.length)
    length, next_length : In(widths.length)
        Lengths of the segments before and after the arc.
    radius : In(RADIUS_BITS)
    back, on : Out(widths.share)
        The tangent as shares of these segments.
    arc_length : Out(widths.arc)
    """

    widths: InstanceOf(Widths)
    point_cycles: Choice(1, 2, text="Cycles of a slot.")

    def interface(self):
        widths = self.widths
        self.divider = Divider(widths.length, widths.share)
        self.step = WideMultiplier(_STEP_BITS, _REST_BITS, _REST_BITS)
        self.arc = WideMultiplier(RADIUS_BITS, TURN_BITS, TURN_FRACTION)
        shares = self.divider.latency + self.point_cycles - 1
        # Registers of place, index, entry, step and turn, and the twin of the entry.
        arc = 3 + 2 * self.point_cycles + self.step.latency + self.arc.latency
        self.latency = slot_after(max(shares, arc), self.point_cycles)
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

        stages = Schedule(m, self.phase, self.point_cycles)
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
        """Return the length of the arc as a held value."""
        half_turn = Timed(self.half_turn, 0)
        # Turns sharper than the table's sharpest count as that one.
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


def corner_layout(widths: Widths) -> data.StructLayout:
    """Return the layout of a point for arcs: a corner, and its ``altitude`` in parts."""
    return data.StructLayout(
        {"x": widths.coordinate, "y": widths.coordinate, "altitude": widths.part}
    )


class ArcPlacer(Unit):
    """Places an arc's ends on the two segments that meet at its waypoint.

    The window of three points advances when the fitter of
    :mod:`pathgene.hdl.planner.scorer.arc_fitter` says so; the arc is at the point in the middle.

    Source: steps 3 and, for chords, "The score" in ``docs/chip_planner.md``.

    Attributes
    ----------
    latency : int
        Cycles from a slot to the slot of its arc.

    Members
    -------
    phase : In(1)
    moves : In(1)
        ``corner`` enters the window at the end of this slot.
    corner : In(corner_layout)
    curves : In(1)
        There is an arc, with a tangent above 0.
    back, on : In(widths.share)
        Shares of the arc.
    start_altitude : Out(widths.part)
        Altitude of the point before the arc.
    before, after : Out(widths.part)
        Altitudes of the ends of the arc, or of the point if there is no arc.
    rise : Out(signed(widths.part + SHARE_BITS + 2))
        Difference of these altitudes with 16 more bits.
    ends : Out(end_layout).array(2)
        Ends of the chord, if there is an arc.
    """

    widths: InstanceOf(Widths)
    point_cycles: Choice(1, 2, text="Cycles of a slot.")

    def interface(self):
        widths = self.widths
        self.rises = WideMultiplier(signed(widths.part + 1), widths.share)
        self.across = {
            axis: WideMultiplier(signed(widths.coordinate + 1), widths.share) for axis in ("x", "y")
        }
        latency = 1 + self.point_cycles + self.rises.latency
        self.latency = slot_after(latency, self.point_cycles)
        self.end_layout = data.StructLayout(
            {"x": widths.coordinate, "y": widths.coordinate, "altitude": widths.altitude}
        )
        return {
            "phase": In(1),
            "moves": In(1),
            "corner": In(corner_layout(widths)),
            "curves": In(1),
            "back": In(widths.share),
            "on": In(widths.share),
            "start_altitude": Out(widths.part),
            "before": Out(widths.part),
            "after": Out(widths.part),
            "rise": Out(signed(widths.part + SHARE_BITS + 2)),
            "ends": Out(self.end_layout).array(2),
        }

    def elaborate(self, platform):
        m = Module()

        window = [
            Signal(corner_layout(self.widths), name=name, reset_less=True)
            for name in ("following", "here", "previous")
        ]
        with m.If(self.phase & self.moves):
            sources = [self.corner, *window[:-1]]
            m.d.sync += [each.eq(source) for each, source in zip(window, sources, strict=True)]

        stages = Schedule(m, self.phase, self.point_cycles)
        following, here, previous = (
            {axis: Timed(each[axis], 0) for axis in ("x", "y", "altitude")} for each in window
        )
        share = stages.compute(
            "share",
            lambda share, curves: Mux(curves, share, 0),
            stages.mux(Timed(self.back, 0), Timed(self.on, 0)),
            Timed(self.curves, 0),
        )

        def gain(axis, begins, ends):
            """Return the gain from the first of two pairs of points to the second."""
            start, stop = (
                stages.mux(*(each[axis] for each in points)) for points in (begins, ends)
            )
            return stages.compute(f"{axis}_gain", lambda stop, start: stop - start, stop, start)

        rises = stages.through(
            "rises",
            self.rises,
            "product",
            first=gain("altitude", (previous, here), (here, following)),
            second=share,
        )
        fall, climb = stages.apart(rises)
        part = self.widths.part
        results = {
            "before": stages.compute(
                "before_arc",
                lambda here, fall: (here - (fall >> SHARE_BITS))[:part],
                here["altitude"],
                fall,
            ),
            "after": stages.compute(
                "behind_arc",
                lambda here, climb: (here + (climb >> SHARE_BITS))[:part],
                here["altitude"],
                climb,
            ),
            "rise": stages.compute("rise_of_arc", self._rise, fall, climb),
        }
        for axis, product in self.across.items():
            away = stages.through(
                axis,
                product,
                "product",
                first=gain(axis, (here, here), (previous, following)),
                second=share,
            )
            pair = stages.compute(f"{axis}_end", self._nearest, away, here[axis])
            results |= {f"{axis}_{end}": each for end, each in enumerate(stages.apart(pair))}
        self._send(m, stages, results, previous["altitude"])

        return m

    def _rise(self, fall, climb):
        """Return the rise of an arc from the products of its two sides."""
        return (fall + climb)[: len(self.rise)].as_signed()

    def _nearest(self, away, here):
        """Return the corner nearest to the place ``away`` from ``here``; ``away`` is a product."""
        half = C(1 << SHARE_BITS - 1, SHARE_BITS)
        return (away + Cat(half, here) >> SHARE_BITS)[: self.widths.coordinate]

    def _send(self, m, stages, results, start_altitude):
        held = {name: stages.hold(f"{name}_held", each) for name, each in results.items()}
        held["start_altitude"] = start_altitude
        values = {name: stages.at(each, self.latency) for name, each in held.items()}
        m.d.comb += [
            getattr(self, name).eq(values[name])
            for name in ("start_altitude", "before", "after", "rise")
        ]
        for number, name in enumerate(("before", "after")):
            end = self.ends[number]
            m.d.comb += [
                end.x.eq(values[f"x_{number}"]),
                end.y.eq(values[f"y_{number}"]),
                end.altitude.eq(values[name] >> ALTITUDE_FRACTION),
            ]
