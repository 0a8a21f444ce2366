"""Launcher of the points of paths, one in every slot."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.layouts import point_layout
from pathgene.hdl.planner.scorer.measurers import place_layout
from pathgene.hdl.planner.scorer.widths import Widths
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.protocol.planner import ALTITUDE_FRACTION, POSITION_FRACTION


__all__ = ["PointLauncher"]

#: Half a cell.
_HALF = 1 << POSITION_FRACTION - 1


class PointLauncher(Unit):
    """Launches a point in every slot while points arrive: a path with its entry and exit.

    The unit stores one point. It leaves in the last cycle of a slot, for the next slot; in that
    cycle, or if no point is stored, the next point is taken. The first point of a path, or the
    entry, leaves if the point was taken in an earlier cycle, the second is offered, and there was
    room in the previous cycle. The second point is then in time for the following slot; if a later
    point is not in time, slots without ``valid`` precede it.

    Members
    -------
    phase : In(1)
    points : In(stream.Signature(point_layout))
        Points of a path from its start corner to its goal corner, two or more.
    room : In(1)
        A path may begin.
    has_entry, has_exit : In(1)
        There is a point before the start, or after the goal.
    start, goal, entry, exit : In(place_layout)
        Places of a path's ends. The corners of start and goal are among the points; entry and exit
        use the nearest corners. All are steady from the cycle in which a path's first point is
        taken.
    x_limit, y_limit : In(widths.coordinate)
        Highest corner, for entry and exit as well.
    launches : Out(1)
        Pulse: a path begins in the next slot.
    valid : Out(1)
    first, last : Out(1)
        Point of its path.
    x, y : Out(widths.coordinate)
        Corner.
    place : Out(place_layout)
    """

    widths: InstanceOf(Widths)

    def interface(self):
        widths = self.widths
        self.point_layout = point_layout(widths.coordinate, widths.altitude)
        place = place_layout(widths)
        return {
            "phase": In(1),
            "points": In(stream.Signature(self.point_layout)),
            "room": In(1),
            "has_entry": In(1),
            "has_exit": In(1),
            "start": In(place),
            "goal": In(place),
            "entry": In(place),
            "exit": In(place),
            "x_limit": In(widths.coordinate),
            "y_limit": In(widths.coordinate),
            "launches": Out(1),
            "valid": Out(1),
            "first": Out(1),
            "last": Out(1),
            "x": Out(widths.coordinate),
            "y": Out(widths.coordinate),
            "place": Out(place),
        }

    def elaborate(self, platform):
        m = Module()

        # The next point, which waits for its slot, and whether it is the start of a path.
        kept, full, opens = Signal(self.point_layout, reset_less=True), Signal(), Signal(init=1)
        # The next slot begins a path or contains an exit.
        begins, exits = Signal(init=1), Signal()
        enters, may, leaves, uses, had_room = Signal(), Signal(), Signal(), Signal(), Signal()
        m.d.sync += had_room.eq(self.room)
        m.d.comb += [
            enters.eq(begins & self.has_entry),
            may.eq(self.phase & (had_room | ~begins)),
            leaves.eq(may & (exits | full & (self.points.valid | ~begins))),
            uses.eq(may & ~enters & ~exits),
            self.points.ready.eq(uses | ~full),
            self.launches.eq(leaves & begins),
        ]
        with m.If(self.points.valid & self.points.ready):
            m.d.sync += [kept.eq(self.points.p), full.eq(1)]
        with m.Elif(leaves & uses):
            m.d.sync += full.eq(0)
        with m.If(leaves):
            m.d.sync += [
                begins.eq(exits | (uses & kept.last & ~self.has_exit)),
                exits.eq(uses & kept.last & self.has_exit),
            ]
            with m.If(uses):
                m.d.sync += opens.eq(kept.last)

        self._send(m, kept, leaves, begins, opens, enters, exits)

        return m

    def _send(self, m, kept, leaves, begins, opens, enters, exits):
        """Add the registers of the next slot's point."""
        x, y = Signal.like(self.x, reset_less=True), Signal.like(self.y, reset_less=True)
        first, last = Signal(reset_less=True), Signal(reset_less=True)
        place = Signal(place_layout(self.widths), reset_less=True)
        m.d.comb += [
            self.first.eq(first),
            self.last.eq(last),
            self.x.eq(x),
            self.y.eq(y),
            self.place.eq(place),
        ]

        # An entry or exit; goal or exit; any of the four ends.
        outer, back, ends = Signal(), Signal(), Signal()
        m.d.comb += [
            outer.eq(enters | exits),
            back.eq(exits | kept.last),
            ends.eq(outer | opens | kept.last),
        ]
        with m.If(self.phase):
            m.d.sync += [
                self.valid.eq(leaves),
                first.eq(begins),
                last.eq(exits | (kept.last & ~self.has_exit)),
            ]
        for axis, corner in (("x", x), ("y", y)):
            entry, leave = (self._nearest(m, end, axis) for end in ("entry", "exit"))
            with m.If(self.phase):
                m.d.sync += corner.eq(Mux(outer, Mux(back, leave, entry), kept[axis]))
        for axis, fraction in (
            ("x", POSITION_FRACTION),
            ("y", POSITION_FRACTION),
            ("altitude", ALTITUDE_FRACTION),
        ):
            inner = Mux(back, self.goal[axis], self.start[axis])
            outside = Mux(back, self.exit[axis], self.entry[axis])
            with m.If(self.phase):
                m.d.sync += place[axis].eq(
                    Mux(ends, Mux(outer, outside, inner), kept[axis] << fraction)
                )

    def _nearest(self, m, end, axis):
        """Return a register of the coordinate of the corner nearest to an end."""
        limit = getattr(self, f"{axis}_limit")
        nearest = getattr(self, end)[axis] + _HALF >> POSITION_FRACTION
        corner = Signal(self.widths.coordinate, name=f"{end}_corner_{axis}", reset_less=True)
        m.d.sync += corner.eq(Mux(nearest > limit, limit, nearest))
        return corner
