"""The collision checker: paths in, verdicts out."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.feasibility.layouts import count_layout, verdict_layout
from pathgene.hdl.feasibility.parallel.walker import ParallelWalker
from pathgene.hdl.feasibility.result_collector import VERDICT_PLACES, ResultCollector
from pathgene.hdl.feasibility.two_tier.walker import TwoTierWalker
from pathgene.hdl.layouts import cell_layout, point_layout
from pathgene.hdl.primitives.unit import InstanceOf, Unit


__all__ = ["Checker"]


class Checker(Unit):
    """Compares the segments of paths with the map (*allaire two-tier*, section 3).

    A segment has one cell per cell of its longer side, including both ends. Cell k of n + 1 lies
    k/n of the way from the start, halves rounded up, and collides unless the exact altitude there
    is above the ground. A segment within one cell has the altitude of its lower end.
    ``config.checker`` selects the map that a segment is compared with and the number of cells per
    cycle; see the walkers. A path is followed to its first colliding cell or to its end.

    Paths may follow each other without gaps and are then checked without gaps; a verdict does not
    wait for the next path. The verdict is offered one cycle after the walker's step that decides
    the path. Latencies are given by the walkers.

    Members
    -------
    count : In(1)
        Also count colliding cells, so that paths are walked to their end. Steady while ``busy``.
    points : In(stream.Signature(point_layout))
        A path is its 2..max_waypoints + 2 points from the aircraft to the goal; ``last`` marks the
        goal.
    verdicts : Out(stream.Signature(verdict_layout))
        One for each path, in order. While a verdict is not taken, checks continue for some paths,
        and no verdict is lost.
    counts : Out(stream.Signature(count_layout))
        When counting, one for each segment with colliding cells, in the number announced by the
        path's verdict. The first one not yet transferred is offered no later than the verdict.
    busy : Out(1)
        A path has been taken and its verdict has not been transferred, or more points of it are
        expected, as after an early collision.
    collision, clear : Out(1)
        The paper's flags, for one path at a time. One of them rises in the cycle in which the
        verdict is offered: ``collision`` if the path collides, otherwise ``clear``, which the paper
        calls "over". When counting, ``collision`` rises with the first hit. Both fall with the
        first point of a path.
    writes : In(stream.Signature(cell_layout))
        Cells of the map; ``last`` ends a rectangle, after which the two-tier build updates its
        coarse map. Taken only while not ``busy``. Cells never written are undefined.
    lookup_valid : In(1)
    lookup_x, lookup_y : In(coordinate_bits)
        With ``lookup_valid``, a cell: one per cycle, but not while ``busy``, nor in the cycle of a
        write or the cycle after it.
    lookup_altitude : Out(altitude_bits)
        Ground of the cell, ``config.lookup_latency`` cycles later.
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        if config.checker is CheckerBuild.NONE:
            raise ValueError(f"Config.checker must name a build, not {config.checker.value!r}")
        verdicts = verdict_layout(
            config.coordinate_bits, config.segment_bits, config.path_cells_bits
        )
        counts = count_layout(config.coordinate_bits, config.segment_bits)
        points = point_layout(config.coordinate_bits, config.altitude_bits)
        cells = cell_layout(config.coordinate_bits, config.altitude_bits)
        return {
            "count": In(1),
            "points": In(stream.Signature(points)),
            "verdicts": Out(stream.Signature(verdicts)),
            "counts": Out(stream.Signature(counts)),
            "busy": Out(1),
            "collision": Out(1),
            "clear": Out(1),
            "writes": In(stream.Signature(cells)),
            "lookup_valid": In(1),
            "lookup_x": In(config.coordinate_bits),
            "lookup_y": In(config.coordinate_bits),
            "lookup_altitude": Out(config.altitude_bits),
        }

    def elaborate(self, platform):
        m = Module()
        config = self.config

        m.submodules.walker = walker = self._walker()
        m.submodules.results = results = ResultCollector(
            config.coordinate_bits,
            config.segment_bits,
            config.path_cells_bits,
            verdict_places=VERDICT_PLACES if config.paper_core else 1,
            count_places=config.count_places if config.paper_core else 1,
        )
        connect(m, flipped(self.points), walker.points)
        connect(m, results.verdicts, flipped(self.verdicts))
        connect(m, results.counts, flipped(self.counts))

        # The point after a path's last one is the first of the next path.
        inside, remains = Signal(), Signal()
        taken, first = Signal(), Signal()
        m.d.comb += [
            taken.eq(self.points.valid & self.points.ready),
            first.eq(taken & ~inside),
            remains.eq(Mux(taken, ~self.points.p.last, inside)),
        ]
        m.d.sync += inside.eq(remains)

        m.d.comb += [
            walker.count.eq(self.count),
            walker.room.eq(results.room),
            walker.segment_room.eq(results.segment_room),
            walker.drop.eq(results.drop),
            walker.lookup_valid.eq(self.lookup_valid),
            walker.lookup_x.eq(self.lookup_x),
            walker.lookup_y.eq(self.lookup_y),
            self.lookup_altitude.eq(walker.lookup_altitude),
            results.count.eq(self.count),
            results.taken.eq(first),
            results.begins.eq(walker.begins),
            results.segment_begins.eq(walker.segment_begins),
            results.step.eq(walker.step),
        ]

        # The walker's `ready` covers its own reasons to wait.
        m.d.comb += [
            walker.writes.p.eq(self.writes.p),
            walker.writes.valid.eq(self.writes.valid & ~self.busy),
            self.writes.ready.eq(walker.writes.ready & ~self.busy),
        ]

        # Paths in flight, which have a place for their verdict or are about to get one.
        paths, was_first, waited_for = Signal(range(64)), Signal(), Signal()
        transferred = self.verdicts.valid & self.verdicts.ready
        m.d.sync += [
            # A first point arrives late in its cycle and is counted in the next cycle.
            was_first.eq(first),
            paths.eq(paths + was_first - transferred),
            waited_for.eq(was_first | Mux(transferred, paths > 1, paths.any())),
        ]
        m.d.comb += self.busy.eq(inside | was_first | waited_for)

        with m.If(first):
            m.d.sync += [self.collision.eq(0), self.clear.eq(0)]
        with m.If(results.hit):
            m.d.sync += self.collision.eq(1)
        with m.If(results.free):
            m.d.sync += self.clear.eq(1)

        return m

    def _walker(self):
        if self.config.checker is CheckerBuild.TWO_TIER:
            return TwoTierWalker(self.config)
        return ParallelWalker(self.config)
