"""Walker of paths: hits and margins, segment by segment, with a memo."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from hdl.config import Config
from hdl.feasibility.result_queue import ResultQueue
from hdl.layouts import cell_layout, point_layout
from hdl.planner.walker.layouts import chord_layout, corner_layout
from hdl.planner.walker.memo import Memo
from hdl.planner.walker.path_reducer import PathReducer, margin_layout
from hdl.planner.walker.segment_source import SegmentSource
from hdl.planner.walker.segment_walker import SegmentWalker
from hdl.primitives.arguments import check_power_of_two


__all__ = ["PathWalker"]

#: Paths that can be on their way: more than fit between a path's first segment and its result, if
#: the memo answers for all of them.
_PLACES = 16


class PathWalker(wiring.Component):
    """Walks paths: corners that collide, and the margins of the waypoints.

    Each segment of a path is walked in order, then the chord at its end; before them all the chord
    at the start, if there is one. A segment or chord takes a cycle if the memo answers for it, else
    n / ``config.lanes`` cycles for n corners, rounded up; the next one follows right behind, and so
    does the next path. A path with ``first`` is walked to its end, too, so that the memo does not
    depend on how many cycles a result takes; nothing behind its first collision counts.

    The first segment or chord of a path is launched 5 cycles after its first point and its first
    chord are offered, or later if segments before it are still launched. With ``has_entry``, a path
    without a chord at its start may take a cycle more. ``results`` offers the path 4 cycles after
    :class:`SegmentWalker` has the result of its last segment, if no result before it waits. See
    :mod:`sim.model.planner.walker_cycles`.

    Parameters
    ----------
    config : Config
    memo_rows : int
        Segments of the memo: 0, or a power of two from 2 on.

    Attributes
    ----------
    hits_bits : int
        Width of the hits of a path.

    Members
    -------
    start : In(corner_layout)
        Where each path begins.
    has_entry, has_exit : In(1)
        There are chords for the start of each path, and for its goal. All three are steady while
        there are points or chords.
    first : In(1)
        Count the hits of a path up to the first segment or chord that collides. Read while the
        first point of a path is offered, and steady until it is taken.
    points : In(stream.Signature(point_layout))
        Points of the paths without the start; ``last`` marks the goal.
    chords : In(stream.Signature(chord_layout))
        One for each inner point, for the start with ``has_entry``, and for the goal with
        ``has_exit``, in the order of the points.
    margins : Out(margin_layout)
        Margins of the waypoints, path by path, as far as they are known. There is no back-pressure.
    results : Out(stream.Signature({"hits": hits_bits}))
        A result for each path, in order, once its margins have been given.
    clear : In(1)
        Void the memo: the map has changed. Only while no path is walked and ``busy`` is low.
    busy : Out(1)
        The memo's rows are made void one by one, and no path is taken: after a reset, and rarely
        after ``clear``.
    writes : In(stream.Signature(cell_layout))
        See :class:`hdl.planner.walker.segment_walker.SegmentWalker`.

    Raises
    ------
    TypeError, ValueError
        If ``memo_rows`` is not an integer, or neither 0 nor such a power.
    """

    def __init__(self, config: Config, memo_rows: int = 512):
        if memo_rows != 0:
            check_power_of_two("Rows", memo_rows, 2, 1 << 16)
        self.config = config
        self.memo_rows = memo_rows
        sizes = (config.coordinate_bits, config.altitude_bits)
        self.hits_bits = ((2 * config.max_segments + 1) * config.map_size).bit_length()
        self.result_layout = data.StructLayout({"hits": self.hits_bits})
        super().__init__(
            {
                "start": In(corner_layout(*sizes)),
                "has_entry": In(1),
                "has_exit": In(1),
                "first": In(1),
                "points": In(stream.Signature(point_layout(*sizes))),
                "chords": In(stream.Signature(chord_layout(*sizes))),
                "margins": Out(margin_layout(config.altitude_bits, config.index_bits)),
                "results": Out(stream.Signature(self.result_layout)),
                "clear": In(1),
                "busy": Out(1),
                "writes": In(stream.Signature(cell_layout(*sizes))),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config
        sizes = (config.coordinate_bits, config.altitude_bits)

        m.submodules.source = source = SegmentSource(*sizes)
        m.submodules.memo = memo = Memo(self.memo_rows, *sizes)
        m.submodules.walker = walker = SegmentWalker(
            config.lanes, *sizes, memo.row_bits, config.memory_latency
        )
        m.submodules.reducer = reducer = PathReducer(*sizes, config.index_bits, self.hits_bits)
        m.submodules.queue = queue = ResultQueue(self.result_layout, _PLACES)
        connect(m, flipped(self.points), source.points)
        connect(m, flipped(self.chords), source.chords)
        connect(m, source.segments, memo.segments)
        connect(m, memo.found, walker.segments)
        connect(m, flipped(self.writes), walker.writes)
        connect(m, queue.words, flipped(self.results))
        m.d.comb += [
            source.start.eq(self.start),
            source.first.eq(self.first),
            source.has_entry.eq(self.has_entry),
            source.has_exit.eq(self.has_exit),
            memo.clear.eq(self.clear),
            self.busy.eq(memo.busy),
            memo.walked.eq(walker.walked),
            reducer.walked.eq(memo.results),
            self.margins.eq(reducer.margin),
            queue.put.eq(reducer.done),
            queue.word.hits.eq(reducer.hits),
        ]

        # Each path on its way has a place in the queue.
        under_way = Signal(range(_PLACES + 1))
        taken = self.results.valid & self.results.ready
        m.d.comb += source.room.eq(under_way != _PLACES)
        m.d.sync += under_way.eq(under_way + source.begins - taken)

        return m
