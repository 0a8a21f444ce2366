"""Hits of paths and margins of their waypoints, reduced from segments and chords."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.walker.layouts import MARKS, walked_layout
from pathgene.hdl.primitives.unit import Unit, Width


__all__ = ["PathReducer", "margin_layout", "result_layout"]


def margin_layout(altitude_bits: int, index_bits: int) -> data.StructLayout:
    """Return the layout of the margin of a waypoint: ``valid`` for a cycle, with the rest.

    ``index``: its position in its path, 0 the first waypoint after the start.
    """
    return data.StructLayout({"valid": 1, "index": index_bits, "margin": signed(altitude_bits + 1)})


def result_layout(hits_bits: int) -> data.StructLayout:
    """Return the layout of the walk of a path: ``valid`` for a cycle, with the rest.

    ``hits``: corners that collide.
    """
    return data.StructLayout({"valid": 1, "hits": hits_bits})


class PathReducer(Unit):
    """Adds up the hits of a path, and gives the margin of each of its waypoints.

    The margin of a waypoint is the minimum over its two segments and its chord; it is given with
    the segment after it. With ``first``, hits after the first segment or chord that collides do not
    count; margins always do. Outputs follow ``walked`` by a cycle.

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
        is_under_way = Signal()  # The path has had a segment, not only the chord at its start.
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
