"""Walker of paths: hits and margins, segment by segment, with a memo."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import Config
from pathgene.hdl.layouts import cell_layout
from pathgene.hdl.planner.layouts import row_layout
from pathgene.hdl.planner.walker.layouts import MARKS, segment_request_layout
from pathgene.hdl.planner.walker.memo import Memo
from pathgene.hdl.planner.walker.path_reducer import PathReducer, margin_layout, result_layout
from pathgene.hdl.planner.walker.segment_walker import SegmentWalker
from pathgene.hdl.primitives.unit import InstanceOf, PowerOfTwo, Unit
from pathgene.hdl.protocol.planner import MEMO_ROWS


__all__ = ["PathWalker"]


class PathWalker(Unit):
    """Walks paths: corners that collide, and the margins of the waypoints.

    A segment or chord takes a cycle if the memo answers for it, else n / ``config.lanes`` cycles
    for n corners, rounded up; the next one follows right after, and so does the next path. A path
    with ``first`` is walked to its end, too: no hits after its first collision count, but margins
    do, and the memo does not depend on how many cycles a result takes.

    A segment is launched 5 cycles after it is offered, or later if segments before it are still
    being launched. ``result`` follows the last group of a path by ``latency`` cycles. See
    :mod:`pathgene.sim.model.planner.walker_cycles`.

    Attributes
    ----------
    hits_bits : int
        Width of the hits of a path.
    latency : int
    row_latency : int
        Cycles from ``row`` to ``corners``.

    Members
    -------
    segments : In(stream.Signature(segment_request_layout))
        Segments of the paths in order, each followed by the chord at its end, with their marks.
    margin : Out(margin_layout)
        Margins of all waypoints, path by path.
    result : Out(result_layout)
        Result of each path, in order, with its last margin or later.
    launching : Out(1)
        A group of corners, or an answer of the memo, was launched, some cycles ago: as many cycles
        are high as the segments cost.
    clear : In(1)
        Void the memo: the map has changed. Only while no path is walked and ``busy`` is low.
    busy : Out(1)
        The memo's rows are made void one by one, and no segment is taken: after a reset, and rarely
        after ``clear``.
    writes : In(stream.Signature(cell_layout))
    row : In(row_layout)
    corners : Out(config.altitude_bits).array(config.lanes)
        See :class:`pathgene.hdl.planner.walker.segment_walker.SegmentWalker`.
    """

    config: InstanceOf(Config)
    memo_rows: PowerOfTwo(2, 1 << 16, "Segments of the memo.", name="Rows", also=(0,)) = MEMO_ROWS

    def interface(self):
        config = self.config
        sizes = (config.coordinate_bits, config.altitude_bits)
        self.hits_bits = ((2 * config.max_segments + 1) * config.map_size).bit_length()
        self.memo = Memo(self.memo_rows, *sizes)
        self.walker = SegmentWalker(config.lanes, *sizes, self.memo.row_bits, config.memory_latency)
        self.latency = self.walker.latency + 3
        self.row_latency = self.walker.row_latency
        return {
            "segments": In(stream.Signature(segment_request_layout(*sizes, MARKS))),
            "margin": Out(margin_layout(config.altitude_bits, config.index_bits)),
            "result": Out(result_layout(self.hits_bits)),
            "launching": Out(1),
            "clear": In(1),
            "busy": Out(1),
            "writes": In(stream.Signature(cell_layout(*sizes))),
            "row": In(row_layout(config.lanes, config.coordinate_bits)),
            "corners": Out(config.altitude_bits).array(config.lanes),
        }

    def elaborate(self, platform):
        m = Module()
        config = self.config

        m.submodules.memo = memo = self.memo
        m.submodules.walker = walker = self.walker
        m.submodules.reducer = reducer = PathReducer(
            config.coordinate_bits, config.altitude_bits, config.index_bits, self.hits_bits
        )
        connect(m, flipped(self.segments), memo.segments)
        connect(m, memo.found, walker.segments)
        connect(m, flipped(self.writes), walker.writes)
        m.d.comb += [
            memo.clear.eq(self.clear),
            self.busy.eq(memo.busy),
            memo.walked.eq(walker.walked),
            reducer.walked.eq(memo.results),
            self.margin.eq(reducer.margin),
            self.result.eq(reducer.result),
            walker.row.eq(self.row),
            *(own.eq(corner) for own, corner in zip(self.corners, walker.corners, strict=True)),
        ]

        # A segment is launched in the second cycle after it is taken, or when those before it are
        # done. So ``walker.latency`` cycles ago a group was launched if a segment taken two cycles
        # before that, or earlier, had not come back by now.
        taken = Signal(walker.latency + 2)
        under_way = Signal(2)
        m.d.comb += self.launching.eq((under_way != 0) | taken[-1])
        m.d.sync += [
            taken.eq(Cat(memo.found.valid & memo.found.ready, taken)),
            under_way.eq(under_way + taken[-1] - walker.walked.valid),
        ]

        return m
