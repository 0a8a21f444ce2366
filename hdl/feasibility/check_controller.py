"""Controller of the checks that commands request, with the source of their points."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.feasibility.layouts import count_layout, verdict_layout
from pathgene.hdl.feasibility.result_store import RecordLayouts, ResultStore
from pathgene.hdl.layouts import (
    check_layout,
    point_layout,
    read_layout,
    record_layout,
    result_read_layout,
    struct,
    waypoint_layout,
)
from pathgene.hdl.primitives.buffers import SkidBuffer, StreamRegister
from pathgene.hdl.primitives.storage import CommitRing
from pathgene.hdl.primitives.unit import Count, InstanceOf, Unit, Width
from pathgene.hdl.protocol.codes import COUNTER_BITS, Counter
from pathgene.hdl.protocol.messages import check_reply


__all__ = ["CheckController", "PathSource", "check_counters_layout"]


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


#: Counters of checks.
check_counters_layout = data.StructLayout(
    {
        counter.value: COUNTER_BITS
        for counter in (Counter.FEASIBILITY, Counter.CELLS, Counter.READS, Counter.PATHS)
    }
)


class CheckController(Unit):
    """Gives the checker its points, and keeps its results until the next check.

    A check is done two cycles after the last verdict and the last of its entries. Neither the link
    nor the population slows the checker: it is offered a point in every cycle, and its results are
    always taken.

    Members
    -------
    on, done : In(1), Out(1)
        Handshake with the control unit.
    checks : In(check_layout)
        Check to run, steady while ``on``.
    forget, points
        Points of one path; see :class:`pathgene.hdl.feasibility.check_controller.PathSource`.
    reads : Out(stream), waypoints : In(stream)
        Paths to read from the population, if there is one, and their waypoints.
    counting : Out(1)
        Count the colliding cells; steady while the checker is busy.
    paths : Out(stream.Signature(point_layout))
        To the checker.
    verdicts : In(stream.Signature(verdict_layout))
    counts : In(stream.Signature(count_layout))
        From the checker; always ready.
    counters : Out(StructLayout({counter: 48, ...}))
        Sums over all verdicts since reset.
    checked : Out(9)
        Paths of the latest check.
    totals : Out, result_reads : In(stream), records : Out(stream)
        Its results; see :class:`pathgene.hdl.feasibility.result_store.ResultStore`.
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        if config.checker is CheckerBuild.NONE:
            raise ValueError(f"Config.checker must name a build, not {config.checker.value!r}")
        self.verdict_layout = verdict_layout(
            config.coordinate_bits, config.segment_bits, config.path_cells_bits
        )
        self.count_layout = count_layout(config.coordinate_bits, config.segment_bits)
        points = point_layout(config.coordinate_bits, config.altitude_bits)
        population = {
            "reads": Out(stream.Signature(read_layout(config.slot_bits))),
            "waypoints": In(stream.Signature(waypoint_layout(config.waypoint_bits))),
        }
        return {
            "on": In(1),
            "done": Out(1),
            "checks": In(check_layout(config.waypoint_bits)),
            "forget": In(1),
            "points": In(stream.Signature(points)),
            **(population if config.paper_core else {}),
            "counting": Out(1),
            "paths": Out(stream.Signature(points)),
            "verdicts": In(stream.Signature(self.verdict_layout)),
            "counts": In(stream.Signature(self.count_layout)),
            "counters": Out(check_counters_layout),
            "checked": Out(9),
            "totals": Out(struct(check_reply(config))),
            "result_reads": In(stream.Signature(result_read_layout)),
            "records": Out(stream.Signature(record_layout)),
        }

    def elaborate(self, platform):
        m = Module()
        config = self.config

        m.submodules.source = source = PathSource(
            config.coordinate_bits,
            config.altitude_bits,
            config.max_waypoints,
            config.population if config.paper_core else None,
        )
        m.submodules.store = store = ResultStore(
            config.checked_paths,
            config.max_segments,
            self.verdict_layout,
            self.count_layout,
            RecordLayouts.of(config),
        )
        connect(m, flipped(self.points), source.points)
        if config.paper_core:
            connect(m, source.reads, flipped(self.reads))
            m.submodules.read = read = StreamRegister(self.waypoints.payload.shape())
            connect(m, flipped(self.waypoints), read.words)
            connect(m, read.passed, source.waypoints)
            # On a large chip, the checker's `ready` arrives late; a skid buffer breaks the path.
            m.submodules.skid = skid = SkidBuffer(source.paths.payload.shape())
            m.submodules.register = register = StreamRegister(skid.shape)
            connect(m, source.paths, skid.words)
            connect(m, skid.passed, register.words)
            connect(m, register.passed, flipped(self.paths))
        else:
            connect(m, source.paths, flipped(self.paths))
        connect(m, flipped(self.verdicts), store.verdicts)
        connect(m, flipped(self.counts), store.counts)
        connect(m, flipped(self.result_reads), store.reads)
        connect(m, store.records, flipped(self.records))

        was_on = Signal()
        cleared = Signal()  # The store only holds results of this check.
        wanted = Signal(9, reset_less=True)
        # There is time for a register before the first point, so that the decoding of the command
        # is not on the checker's path.
        m.d.sync += [
            was_on.eq(self.on),
            cleared.eq(self.on & was_on),
            self.counting.eq(self.checks.counting),
            wanted.eq(Mux(self.checks.batch, self.checks.count, 1)),
            self.done.eq(self.on & cleared & (store.paths == wanted) & store.complete & ~self.done),
        ]
        m.d.comb += [
            source.forget.eq(self.forget),
            source.on.eq(self.on),
            source.checks.eq(self.checks),
            store.clear.eq(self.on & ~was_on),
            self.checked.eq(store.paths),
            self.totals.eq(store.totals),
        ]

        # Sums are wide, so they add registers instead of the checker's outputs.
        came = Signal()
        counters, verdict = self.counters, Signal.like(self.verdicts.p, reset_less=True)
        m.d.sync += [
            came.eq(self.verdicts.valid & self.verdicts.ready),
            verdict.eq(self.verdicts.p),
        ]
        with m.If(came):
            m.d.sync += [
                counters[Counter.FEASIBILITY].eq(counters[Counter.FEASIBILITY] + verdict.cycles),
                counters[Counter.CELLS].eq(counters[Counter.CELLS] + verdict.cells),
                counters[Counter.READS].eq(counters[Counter.READS] + verdict.reads),
                counters[Counter.PATHS].eq(counters[Counter.PATHS] + 1),
            ]

        return m
