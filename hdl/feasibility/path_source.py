"""Source of points for the collision checker: a single path, or paths of the population."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.layouts import check_layout, point_layout, read_layout, waypoint_layout
from pathgene.hdl.primitives.storage import CommitRing
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["PathSource"]


class PathSource(Unit):
    """Offers the checker a point in every cycle, from the first to the last of a check.

    Between two paths, the population's reader pauses for a cycle in addition to the two for the
    goal and the next aircraft. The points therefore go through a buffer, which is released once it
    holds enough points to cover the pauses of the paths still to be read.

    The first point of a single path is offered 4 cycles after the unit is turned on, the first
    point of a batch at most ``13 + count * 5 / 4`` cycles after.

    Without a population there are no batches. The buffer is one block RAM on the target.

    Attributes
    ----------
    depth : int
        Points that the buffer holds.

    Members
    -------
    forget : In(1)
        Discard points that were given but not checked. Not while ``on``.
    points : In(stream.Signature(point_layout))
        Points of one path. There is room for a path after ``forget``; not taken while ``on``.
    on : In(1)
        A check is in progress; high until the checker has all its points.
    checks : In(check_layout)
        Check to run, steady while ``on``. The points of a single path must have been given before.
    reads : Out(stream.Signature(read_layout))
        Slots to be read from the population, if there is one.
    waypoints : In(stream.Signature(waypoint_layout))
        Their waypoints.
    paths : Out(stream.Signature(point_layout))
        Points for the checker; ``last`` marks each goal.
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    max_waypoints: Count(1, text="Waypoints of the longest path.")
    population: Count(2, 256, "None on a chip without a population.", also=(None,))

    def interface(self):
        self.point_layout = point_layout(self.coordinate_bits, self.altitude_bits)
        waypoint_bits = 2 * self.coordinate_bits + self.altitude_bits
        # Room for one path, and for twice the backlog of a batch.
        rows = max(2 * (self.population or 1), self.max_waypoints + 2)
        self.depth = 1 << (rows - 1).bit_length()
        reader = {}
        if self.population is not None:
            reader = {
                "reads": Out(stream.Signature(read_layout((self.population - 1).bit_length()))),
                "waypoints": In(stream.Signature(waypoint_layout(waypoint_bits))),
            }
        return {
            "forget": In(1),
            "points": In(stream.Signature(self.point_layout)),
            "on": In(1),
            "checks": In(check_layout(waypoint_bits)),
            **reader,
            "paths": Out(stream.Signature(self.point_layout)),
        }

    def elaborate(self, platform):
        m = Module()
        checks = self.checks

        m.submodules.ring = ring = CommitRing(self.point_layout, self.depth)
        connect(m, ring.words, flipped(self.paths))

        tail = Signal.like(ring.committed)
        committed = Signal.like(ring.committed)
        waiting = Signal.like(ring.committed)
        room = Signal()
        point = Signal(self.point_layout)
        write = Signal()
        put = Signal()
        let_out = Signal()
        m.d.comb += [
            ring.committed.eq(committed),
            waiting.eq(tail - ring.fetched),
            room.eq(~waiting[-1]),
            put.eq(write & room),
        ]
        # A point is written one cycle after it is counted, and not released before that.
        m.d.sync += [
            ring.write_enable.eq(put),
            ring.write_row.eq(tail),
            ring.write_data.eq(point),
        ]
        with m.If(put):
            m.d.sync += tail.eq(tail + 1)
        with m.Elif(self.forget):
            m.d.sync += tail.eq(committed)
        with m.If(let_out):
            m.d.sync += committed.eq(tail)

        with m.FSM():
            with m.State("Off"):
                m.d.comb += [
                    point.eq(self.points.p),
                    write.eq(self.points.valid & ~self.on),
                    self.points.ready.eq(room & ~self.on),
                ]
                with m.If(self.on):
                    m.next = "All"
                    if self.population is not None:
                        with m.If(checks.batch):
                            m.next = "Ask"

            if self.population is not None:
                self._read_out(m, point, write, room, put)

            with m.State("All"):
                m.d.comb += let_out.eq(1)
                with m.If(~self.on):
                    m.next = "Off"

        if self.population is not None:
            # Each remaining path may take an extra cycle.
            flowing = Signal()
            with m.If(~self.on):
                m.d.sync += flowing.eq(0)
            with m.Elif(waiting >= checks.count):
                m.d.sync += flowing.eq(checks.batch)
            with m.If(flowing):
                m.d.comb += let_out.eq(1)

        return m

    def _read_out(self, m, point, write, room, put):
        """Add the states that read paths of the population."""
        checks = self.checks
        final = Signal()
        m.d.comb += [
            self.reads.p.slot.eq(checks.slot),
            self.reads.p.count.eq(checks.count),
        ]

        with m.State("Ask"):
            m.d.comb += self.reads.valid.eq(1)
            with m.If(self.reads.ready):
                m.next = "Read"

        with m.State("Read"):
            with m.If(self.waypoints.valid):
                m.next = "Aircraft"

        with m.State("Aircraft"):
            m.d.comb += [point.eq(checks.start), write.eq(1)]
            with m.If(room):
                m.next = "Waypoints"

        with m.State("Waypoints"):
            m.d.comb += [
                point.eq(self.waypoints.p.waypoint),
                write.eq(self.waypoints.valid),
                self.waypoints.ready.eq(room),
            ]
            m.d.sync += final.eq(self.waypoints.p.final)
            with m.If(put & self.waypoints.p.last):
                m.next = "Goal"

        with m.State("Goal"):
            m.d.comb += [point.eq(Cat(checks.goal, 1)), write.eq(1)]
            with m.If(room):
                m.next = "Aircraft"
                with m.If(final):
                    m.next = "All"
