"""Control of the collision checker: runs the checks that the host requests."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.feasibility.layouts import count_layout, verdict_layout
from pathgene.hdl.feasibility.path_source import PathSource
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
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.protocol import COUNTER_BITS, Counter, check_reply


__all__ = ["CheckController", "check_counters_layout"]


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
        Points of one path; see :class:`pathgene.hdl.feasibility.path_source.PathSource`.
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
