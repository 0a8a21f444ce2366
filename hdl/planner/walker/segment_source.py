"""Source of the segments and chords of stored paths, in walking order."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.layouts import point_layout
from pathgene.hdl.planner.walker.layouts import (
    MARKS,
    chord_layout,
    corner_layout,
    segment_request_layout,
)
from pathgene.hdl.primitives.unit import Unit, Width


__all__ = ["SegmentSource", "queued_layout", "read_layout"]


def queued_layout(place_bits: int, row_bits: int) -> data.StructLayout:
    """Return the layout of a path to be walked.

    ``place`` and ``goal``: its place, and the row of its goal. ``enters``: there is a chord at the
    start. ``first``: its hits end with its first colliding segment or chord.
    """
    return data.StructLayout({"place": place_bits, "goal": row_bits, "enters": 1, "first": 1})


def read_layout(place_bits: int, row_bits: int) -> data.StructLayout:
    """Return the layout of a read of a row of a place, with ``enable``."""
    return data.StructLayout({"enable": 1, "place": place_bits, "row": row_bits})


class SegmentSource(Unit):
    """Reads stored paths, and makes segments from their points, each path without gaps.

    A row is a point and the chord there; row 0 belongs to the start. Every later row yields the
    segment from the previous point, and then the chord if it is present. Row 0 only yields the
    chord, and is only read if there is one, so that each row read yields a segment. Rows are read
    ahead of time, even across the end of a path.

    The first segment of a path is offered 2 cycles after the path, or later if earlier segments are
    not taken. After that, a segment is offered in every cycle, and the next path follows
    immediately.

    Members
    -------
    start : In(corner_layout)
        Start of each path. Steady while paths are walked.
    paths : In(stream.Signature(queued_layout))
        Taken when their last rows are read.
    read : Out(read_layout)
    row : In({"point": point_layout, "chord": chord_layout})
        The row read last, from the cycle after ``read.enable`` on.
    segments : Out(stream.Signature(segment_request_layout))
        With their marks.
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    place_bits: Width(1)
    row_bits: Width(1, text="Row of a place.")

    def interface(self):
        sizes = (self.coordinate_bits, self.altitude_bits)
        row = {"point": point_layout(*sizes), "chord": chord_layout(*sizes)}
        return {
            "start": In(corner_layout(*sizes)),
            "paths": In(stream.Signature(queued_layout(self.place_bits, self.row_bits))),
            "read": Out(read_layout(self.place_bits, self.row_bits)),
            "row": In(data.StructLayout(row)),
            "segments": Out(stream.Signature(segment_request_layout(*sizes, MARKS))),
        }

    def elaborate(self, platform):
        m = Module()
        path, segments = self.paths.p, self.segments
        marks = segments.p.identity

        # Kind of a word's row: the first row of its path, the row of the start, the row after it.
        label_layout = data.StructLayout({"begins": 1, "start": 1, "leaves": 1, "first": 1})
        word_layout = data.StructLayout({"row": self.row.shape(), "label": label_layout})
        loaded, offered = Signal(), Signal()  # Rows in the read port and in ``word``.
        label = Signal(label_layout, reset_less=True)
        word = Signal(word_layout, reset_less=True)
        passes, moves = Signal(), Signal()

        inside, next_row, row = Signal(), Signal(self.row_bits), Signal(self.row_bits)
        m.d.comb += [
            moves.eq(~offered | passes),
            row.eq(Mux(inside, next_row, ~path.enters)),
            self.read.enable.eq(self.paths.valid & (~loaded | moves)),
            self.read.place.eq(path.place),
            self.read.row.eq(row),
            self.paths.ready.eq(self.read.enable & (row == path.goal)),
        ]
        with m.If(self.read.enable):
            m.d.sync += [
                inside.eq(row != path.goal),
                next_row.eq(row + 1),
                loaded.eq(1),
                label.begins.eq(~inside),
                label.start.eq(row == 0),
                label.leaves.eq(row == 1),
                label.first.eq(path.first),
            ]
        with m.Elif(moves):
            m.d.sync += loaded.eq(0)
        with m.If(moves):
            m.d.sync += [offered.eq(loaded), word.row.eq(self.row), word.label.eq(label)]

        # A row yields its segment, then its chord.
        point, chord = word.row.point, word.row.chord
        chord_due = Signal()
        before = Signal(self.start.shape(), reset_less=True)
        m.d.comb += [
            segments.valid.eq(offered),
            marks.chord.eq(chord_due | word.label.start),
            marks.begins.eq(word.label.begins & ~chord_due),
            marks.first.eq(word.label.first),
            marks.last.eq(point.last & (chord_due | ~chord.present)),
            passes.eq(segments.ready & (marks.chord | ~chord.present)),
        ]
        start, stop = segments.p.start, segments.p.stop
        with m.If(marks.chord):
            m.d.comb += [start.eq(chord.start), stop.eq(chord.stop)]
        with m.Else():
            m.d.comb += [
                start.eq(Mux(word.label.leaves, self.start, before)),
                *(stop[axis].eq(point[axis]) for axis in ("x", "y", "altitude")),
            ]
        with m.If(offered & segments.ready):
            m.d.sync += chord_due.eq(~passes)
            with m.If(~marks.chord):
                m.d.sync += before.eq(stop)

        return m
