"""Points of paths, one in every slot."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.layouts import point_layout
from hdl.planner.scorer.segment_measurer import place_layout
from hdl.planner.scorer.widths import Widths
from hdl.protocol.planner import ALTITUDE_FRACTION, POSITION_FRACTION


__all__ = ["PointLauncher"]


class PointLauncher(wiring.Component):
    """Launches a point in every slot, as long as points come.

    A path begins if there is room for all of it, and with its second point at hand: the second
    slot of a path follows the first. A point leaves in the slot after the one in which it is taken.

    Parameters
    ----------
    widths : Widths

    Members
    -------
    points : In(stream.Signature(point_layout))
        Those of a path from its start corner to its goal corner, three or more.
    room : In(1)
        There is room for another path.
    start, goal : In(place_layout)
        Places of a path's first and last point, which its corners are near.
    phase : Out(1)
        1 in the second cycle of every slot.
    launches : Out(1)
        Pulse: a path begins with the next slot.
    launches_inner : Out(1)
        Pulse: the next slot is that of a point between the ends of its path.
    valid : Out(1)
    first, last : Out(1)
        Point of its path.
    x, y : Out(widths.coordinate)
        Corner.
    place : Out(place_layout)
    """

    def __init__(self, widths: Widths):
        self.widths = widths
        self.point_layout = point_layout(widths.coordinate, widths.altitude)
        place = place_layout(widths)
        super().__init__(
            {
                "points": In(stream.Signature(self.point_layout)),
                "room": In(1),
                "start": In(place),
                "goal": In(place),
                "phase": Out(1),
                "launches": Out(1),
                "launches_inner": Out(1),
                "valid": Out(1),
                "first": Out(1),
                "last": Out(1),
                "x": Out(widths.coordinate),
                "y": Out(widths.coordinate),
                "place": Out(place),
            }
        )

    def elaborate(self, platform):
        m = Module()

        # The next point, which waits for its slot, and whether it begins a path.
        kept, full, begins = Signal(self.point_layout, reset_less=True), Signal(), Signal(init=1)
        may, leaves, comes = Signal(), Signal(), Signal()
        m.d.sync += self.phase.eq(~self.phase)
        m.d.comb += [
            may.eq(self.phase & (self.room | ~begins)),
            leaves.eq(full & may & (self.points.valid | ~begins)),
            self.points.ready.eq(may | ~full),
            comes.eq(self.points.valid & self.points.ready),
            self.launches.eq(leaves & begins),
            self.launches_inner.eq(leaves & ~begins & ~kept.last),
        ]
        with m.If(comes):
            m.d.sync += [kept.eq(self.points.p), full.eq(1)]
        with m.Elif(leaves):
            m.d.sync += full.eq(0)
        with m.If(leaves):
            m.d.sync += begins.eq(kept.last)

        corner = {
            "x": kept.x << POSITION_FRACTION,
            "y": kept.y << POSITION_FRACTION,
            "altitude": kept.altitude << ALTITUDE_FRACTION,
        }
        first, last = Signal(reset_less=True), Signal(reset_less=True)
        x, y = Signal.like(self.x, reset_less=True), Signal.like(self.y, reset_less=True)
        place = Signal(place_layout(self.widths), reset_less=True)
        m.d.comb += [
            self.first.eq(first),
            self.last.eq(last),
            self.x.eq(x),
            self.y.eq(y),
            self.place.eq(place),
        ]
        with m.If(self.phase):
            m.d.sync += [
                self.valid.eq(leaves),
                first.eq(begins),
                last.eq(kept.last),
                x.eq(kept.x),
                y.eq(kept.y),
                *(
                    place[axis].eq(
                        Mux(begins, self.start[axis], Mux(kept.last, self.goal[axis], value))
                    )
                    for axis, value in corner.items()
                ),
            ]

        return m
