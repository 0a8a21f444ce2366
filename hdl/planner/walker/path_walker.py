"""Walker of paths: segments and chords, with the memo, to hits and margins."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import Config
from pathgene.hdl.layouts import cell_layout
from pathgene.hdl.planner.layouts import row_layout
from pathgene.hdl.planner.walker.layouts import MARKS, segment_request_layout, walked_layout
from pathgene.hdl.planner.walker.memo import Memo
from pathgene.hdl.planner.walker.segment_walker import SegmentWalker
from pathgene.hdl.primitives.unit import InstanceOf, PowerOfTwo, Unit, Width
from pathgene.hdl.protocol.planner import MEMO_ROWS


__all__ = ["PathReducer", "PathWalker", "margin_layout", "result_layout"]


def margin_layout(altitude_bits: int, index_bits: int) -> data.StructLayout:
    """Return the layout of a waypoint's margin, which is ``valid`` for one cycle.

    ``index``: its position in its path; 0 is the first waypoint after the start.
    """
    return data.StructLayout({"valid": 1, "index": index_bits, "margin": signed(altitude_bits + 1)})


def result_layout(hits_bits: int) -> data.StructLayout:
    """Return the layout of a path's walk, which is ``valid`` for one cycle.

    ``hits``: corners that collide.
    """
    return data.StructLayout({"valid": 1, "hits": hits_bits})


class PathReducer(Unit):
    """Adds up the hits of a path, and outputs the margin of each of its waypoints.

    The margin of a waypoint is the minimum over its two segments and its chord; it is output with
    the segment after it. With ``first``, hits after the first colliding segment or chord do not
    count, but margins always do. Outputs follow ``walked`` by one cycle.

    Members
    -------
    walked : In(walked_layout)
        Segments and chords of the paths in order, with their marks.
    margin : Out(margin_layout)
    result : Out(result_layout)
        Result of each path, with its last margin or later.
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    index_bits: Width(1, text="Position of a waypoint.")
    hits_bits: Width(1)

    def interface(self):
        return {
            "walked": In(walked_layout(self.coordinate_bits, self.altitude_bits, MARKS)),
            "margin": Out(margin_layout(self.altitude_bits, self.index_bits)),
            "result": Out(result_layout(self.hits_bits)),
        }

    def elaborate(self, platform):
        m = Module()
        walked, marks = self.walked, self.walked.identity

        stopped = Signal()
        is_under_way = Signal()  # The path has had a segment, not just the chord at its start.
        index = Signal(self.index_bits, reset_less=True)
        before = Signal.like(walked.margin, reset_less=True)
        margin = Signal.like(walked.margin, reset_less=True)
        hits = Signal.like(self.result.hits, reset_less=True)
        m.d.comb += [
            self.margin.index.eq(index),
            self.margin.margin.eq(margin),
            self.result.hits.eq(hits),
        ]

        counts, is_behind, least = Signal(), Signal(), Signal.like(before)
        m.d.comb += [
            counts.eq(marks.begins | ~stopped),
            is_behind.eq(~marks.begins & ~marks.chord & is_under_way),
            least.eq(Mux(before < walked.margin, before, walked.margin)),
        ]
        m.d.sync += [
            self.result.valid.eq(walked.valid & marks.last),
            self.margin.valid.eq(walked.valid & is_behind),
            margin.eq(least),
        ]
        with m.If(walked.valid):
            m.d.sync += [
                before.eq(Mux(marks.chord, least, walked.margin)),
                stopped.eq(~counts | (marks.first & (walked.hits != 0))),
                hits.eq(Mux(marks.begins, 0, hits) + Mux(counts, walked.hits, 0)),
            ]
            # The index of the waypoint before the next segment.
            with m.If(marks.begins):
                m.d.sync += [index.eq(-1), is_under_way.eq(~marks.chord)]
            with m.Elif(~marks.chord):
                m.d.sync += is_under_way.eq(1)
            with m.If(is_behind):
                m.d.sync += index.eq(index + 1)

        return m


class PathWalker(Unit):
    """Walks paths: counts colliding corners, and finds the margins of the waypoints.

    A segment or chord takes one cycle if the memo answers for it, otherwise n / ``config.lanes``
    cycles for n corners, rounded up; the next segment or path follows without a gap. A path with
    ``first`` is also walked to its end: hits after its first collision do not count, but margins
    do, and the memo does not depend on the time that a result takes.

    A segment is launched 5 cycles after it is offered, or later if earlier segments are still being
    launched. ``result`` follows the last group of a path by ``latency`` cycles. See
    :mod:`pathgene.sim.model.planner.evaluator_cycles`.

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
        A group of corners, or an answer of the memo, was launched a few cycles ago: it is high for
        as many cycles as the segments cost.
    clear : In(1)
        Clear the memo, because the map has changed. Only while no path is walked and ``busy`` is
        low.
    busy : Out(1)
        The rows of the memo are being cleared one by one, and no segment is taken: after a reset,
        and rarely after ``clear``.
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

        # A segment is launched in the second cycle after it is taken, or when earlier segments are
        # done. Therefore a group was launched ``walker.latency`` cycles ago if a segment taken at
        # least two cycles before that has not returned by now.
        taken = Signal(walker.latency + 2)
        under_way = Signal(2)
        m.d.comb += self.launching.eq((under_way != 0) | taken[-1])
        m.d.sync += [
            taken.eq(Cat(memo.found.valid & memo.found.ready, taken)),
            under_way.eq(under_way + taken[-1] - walker.walked.valid),
        ]

        return m
