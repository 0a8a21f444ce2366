"""Altitudes at the ends of an arc, and its chord."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.scorer.schedule import Schedule, Timed
from pathgene.hdl.planner.scorer.widths import Widths
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.primitives.wide_multiplier import WideMultiplier
from pathgene.hdl.protocol.planner import ALTITUDE_FRACTION, SHARE_BITS


__all__ = ["ArcPlacer", "corner_layout"]


def corner_layout(widths: Widths) -> data.StructLayout:
    """Return the layout of a point as arcs see it: a corner, and its ``altitude`` in parts."""
    return data.StructLayout(
        {"x": widths.coordinate, "y": widths.coordinate, "altitude": widths.part}
    )


class ArcPlacer(Unit):
    """Places an arc's ends on the two segments that meet at its waypoint.

    The window of three points moves on where
    :class:`pathgene.hdl.planner.scorer.arc_fitter.ArcFitter` says so; the arc is at the point in
    the middle.

    Source: steps 3 and, for chords, "The score" in ``docs/chip_planner.md``.

    Attributes
    ----------
    latency : int
        Cycles from a slot to the slot of its arc.

    Members
    -------
    phase : In(1)
        1 in the second cycle of every slot.
    moves : In(1)
        ``corner`` enters the window at the end of this slot.
    corner : In(corner_layout)
    curves : In(1)
        There is an arc, with a tangent above 0.
    back, on : In(widths.share)
        Its shares.
    start_altitude : Out(widths.part)
        Altitude of the point before the arc.
    before, after : Out(widths.part)
        Altitudes of the ends of the arc, or of the point if there is no arc.
    rise : Out(signed(widths.part + SHARE_BITS + 2))
        Their difference with 16 more bits.
    ends : Out(end_layout).array(2)
        Ends of the chord, if there is an arc.
    """

    widths: InstanceOf(Widths)

    def interface(self):
        widths = self.widths
        self.rises = WideMultiplier(signed(widths.part + 1), widths.share)
        self.across = {
            axis: WideMultiplier(signed(widths.coordinate + 1), widths.share) for axis in ("x", "y")
        }
        self.latency = (3 + self.rises.latency | 1) + 1
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

        stages = Schedule(m, self.phase)
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
            "rise": stages.compute("rise_of_arc", lambda fall, climb: fall + climb, fall, climb),
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

    def _nearest(self, away, here):
        """Return the corner nearest to the place that lies ``away`` from ``here``, a product."""
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
