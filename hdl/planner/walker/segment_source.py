"""Segments and chords of paths, in the order in which they are walked."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.layouts import point_layout
from hdl.planner.walker.layouts import MARKS, chord_layout, corner_layout, segment_request_layout
from hdl.primitives.arguments import check_integer


__all__ = ["SegmentSource"]


class SegmentSource(wiring.Component):
    """Makes segments of points: from each to the next, and the chord at its end if there is one.

    A segment is offered while its point is, and the point's chord, which tells whether the segment
    is the last one; a present chord is offered next. One that is not present costs no cycle, but at
    the start, where nothing is offered beside it. The first segment or chord of a path waits for
    ``room``, and for the first point.

    Parameters
    ----------
    coordinate_bits, altitude_bits : int
        Widths of a coordinate and of an altitude, 1 or more.

    Members
    -------
    start : In(corner_layout)
        Where each path begins.
    has_entry, has_exit : In(1)
        There are chords for the start of each path, and for its goal. All three are steady while
        there are points or chords.
    first : In(1)
        The hits of a path end with its first segment or chord that collides. Read while the first
        point of the path is offered, and steady until it is taken.
    room : In(1)
        A path may begin. Once high, it stays so until a path begins.
    begins : Out(1)
        A path does, in the cycle in which its first segment or chord is taken.
    points : In(stream.Signature(point_layout))
        Points of the paths without the start; ``last`` marks the goal.
    chords : In(stream.Signature(chord_layout))
        One for each inner point, for the start with ``has_entry``, and for the goal with
        ``has_exit``, in the order of the points.
    segments : Out(stream.Signature(segment_request_layout))
        With their marks.

    Raises
    ------
    TypeError, ValueError
        If a parameter is not an integer, or out of its range.
    """

    def __init__(self, coordinate_bits: int, altitude_bits: int):
        check_integer("Coordinate width", coordinate_bits, 1)
        check_integer("Altitude width", altitude_bits, 1)
        self.coordinate_bits = coordinate_bits
        self.altitude_bits = altitude_bits
        sizes = (coordinate_bits, altitude_bits)
        super().__init__(
            {
                "start": In(corner_layout(*sizes)),
                "has_entry": In(1),
                "has_exit": In(1),
                "first": In(1),
                "room": In(1),
                "begins": Out(1),
                "points": In(stream.Signature(point_layout(*sizes))),
                "chords": In(stream.Signature(chord_layout(*sizes))),
                "segments": Out(stream.Signature(segment_request_layout(*sizes, MARKS))),
            }
        )

    def elaborate(self, platform):
        m = Module()
        points, chords, segments = self.points, self.chords, self.segments
        point, chord, marks = points.p, chords.p, segments.p.identity

        begun = Signal()  # The path's first segment or chord has been taken.
        inside, first = Signal(), Signal()  # Its first segment has.
        entered = Signal()  # The chord at the start has been seen.
        chord_due, at_goal = (
            Signal(),
            Signal(),
        )  # A chord is next, behind its segment.
        before = Signal(self.start.shape(), reset_less=True)

        starting, needs_chord, may_begin, may_go = (Signal() for _ in range(4))
        m.d.comb += [
            starting.eq(self.has_entry & ~entered),
            needs_chord.eq(~point.last | self.has_exit),
            may_begin.eq(points.valid & (begun | self.room)),
            may_go.eq(may_begin & (chords.valid | ~needs_chord)),
            marks.begins.eq(~begun),
            marks.chord.eq(chord_due | starting),
            marks.first.eq(Mux(inside, first, self.first)),
        ]
        start, stop = segments.p.start, segments.p.stop
        with m.If(marks.chord):
            m.d.comb += [
                start.eq(chord.start),
                stop.eq(chord.stop),
                marks.last.eq(chord_due & at_goal),
                segments.valid.eq(chord_due | (chords.valid & chord.present & may_begin)),
                chords.ready.eq(Mux(chord_due | chord.present, segments.ready & segments.valid, 1)),
            ]
        with m.Else():
            m.d.comb += [
                start.eq(Mux(inside, before, self.start)),
                *(stop[axis].eq(point[axis]) for axis in ("x", "y", "altitude")),
                marks.last.eq(point.last & ~(self.has_exit & chord.present)),
                segments.valid.eq(may_go),
                points.ready.eq(segments.ready & may_go),
                chords.ready.eq(points.ready & needs_chord & ~chord.present),
            ]

        with m.If(starting & chords.valid & chords.ready):
            m.d.sync += entered.eq(1)
        with m.If(segments.valid & segments.ready):
            m.d.comb += self.begins.eq(~begun)
            m.d.sync += begun.eq(~marks.last)
            with m.If(marks.chord):
                m.d.sync += chord_due.eq(0)
            with m.Else():
                m.d.sync += [
                    inside.eq(1),
                    first.eq(marks.first),
                    chord_due.eq(needs_chord & chord.present),
                    at_goal.eq(point.last),
                    *(before[axis].eq(point[axis]) for axis in ("x", "y", "altitude")),
                ]
            with m.If(marks.last):
                m.d.sync += [inside.eq(0), entered.eq(0)]

        return m
