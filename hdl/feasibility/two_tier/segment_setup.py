"""Set-up of segments for the walker of the two-tier build."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.layouts import point_layout
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["TwoTierSegmentSetup", "segment_layout"]


def segment_layout(
    coordinate_bits: int, altitude_bits: int, segment_bits: int
) -> data.StructLayout:
    """Return the layout of one segment to be walked.

    ``x``, ``y`` of its first cell, in cells of its map; ``west`` and ``south``: x, y do not grow;
    ``steep``: y is the longer side. ``steps`` along the longer side and ``minor`` along the
    shorter. ``altitude`` of the first cell (without steps, of the lower end) and ``climb`` to the
    last one. ``coarse``: its map is the coarse one. ``number`` within its path; ``last``: the path
    ends here.
    """
    return data.StructLayout(
        {
            "x": coordinate_bits,
            "y": coordinate_bits,
            "west": 1,
            "south": 1,
            "steep": 1,
            "steps": coordinate_bits,
            "minor": coordinate_bits,
            "altitude": altitude_bits,
            "climb": signed(altitude_bits + 1),
            "coarse": 1,
            "number": segment_bits,
            "last": 1,
        }
    )


class TwoTierSegmentSetup(Unit):
    """Makes segments from points: differences, sides in order of length, and the map.

    The first ``detailed_segments`` of a path are for the detailed map, all later ones for the
    coarse map: their points become the blocks that they lie in, with their own altitudes (*allaire
    two-tier*, section 3.2).

    It is a two-stage pipeline, which takes a point and offers a segment in every cycle: the segment
    is offered 2 cycles after its second point is taken. If ``segments`` is stalled, two segments
    wait here.

    Members
    -------
    points : In(stream.Signature(point_layout))
        Paths of two or more points, one after another.
    segments : Out(stream.Signature(segment_layout))
        Segments of each path, one fewer than its points.
    """

    coordinate_bits: Width(2, text="In cells of the detailed map.")
    coarse_bits: Width(
        1, "coordinate_bits - 1", "Width of a coordinate in cells of the coarse map."
    )
    altitude_bits: Width(1)
    segment_bits: Width(1, text="Number of a segment in its path.")
    detailed_segments: Count(1, text="Segments of a path for the detailed map.")

    def interface(self):
        segments = segment_layout(self.coordinate_bits, self.altitude_bits, self.segment_bits)
        return {
            "points": In(stream.Signature(point_layout(self.coordinate_bits, self.altitude_bits))),
            "segments": Out(stream.Signature(segments)),
        }

    def elaborate(self, platform):
        m = Module()
        xy, z = self.coordinate_bits, self.altitude_bits
        shift = xy - self.coarse_bits

        point = self.points.p
        taken = Signal()
        first = Signal(init=1)
        previous = Signal.like(point, reset_less=True)
        number = Signal(self.segment_bits)
        coarse = Signal()

        measured = Signal()  # The first stage holds a segment: its sides with their signs.
        sides = Signal(
            data.StructLayout(
                {
                    "x": xy,
                    "y": xy,
                    "altitude": z,
                    "goal": z,
                    "climb": signed(z + 1),
                    "across": xy,
                    "along": xy,
                    "west": 1,
                    "south": 1,
                    "coarse": 1,
                    "number": self.segment_bits,
                    "last": 1,
                }
            ),
            reset_less=True,
        )
        move_measured = Signal()

        m.d.comb += [
            move_measured.eq(~self.segments.valid | self.segments.ready),
            self.points.ready.eq(first | ~measured | move_measured),
            taken.eq(self.points.valid & self.points.ready),
        ]

        def located(point):
            """Return the x and y of a point in the cells of the segment's map."""
            return [Mux(coarse, axis >> shift, axis) for axis in (point.x, point.y)]

        (start_x, start_y), (stop_x, stop_y) = located(previous), located(point)
        west = Signal()
        south = Signal()
        m.d.comb += [west.eq(stop_x < start_x), south.eq(stop_y < start_y)]

        with m.If(taken):
            m.d.sync += [
                previous.eq(point),
                first.eq(point.last),
                number.eq(Mux(first, 0, number + 1)),
                coarse.eq(~first & (coarse | (number == self.detailed_segments - 1))),
            ]
            with m.If(~first):
                m.d.sync += [
                    sides.x.eq(start_x),
                    sides.y.eq(start_y),
                    sides.altitude.eq(previous.altitude),
                    sides.goal.eq(point.altitude),
                    sides.climb.eq(point.altitude - previous.altitude),
                    sides.across.eq(Mux(west, start_x - stop_x, stop_x - start_x)),
                    sides.along.eq(Mux(south, start_y - stop_y, stop_y - start_y)),
                    sides.west.eq(west),
                    sides.south.eq(south),
                    sides.coarse.eq(coarse),
                    sides.number.eq(number),
                    sides.last.eq(point.last),
                ]
        with m.If(~measured | move_measured):
            m.d.sync += measured.eq(taken & ~first)

        segment = self.segments.p
        steep = Signal()
        level = Signal()
        m.d.comb += [
            steep.eq(sides.along > sides.across),
            level.eq((sides.across == 0) & (sides.along == 0)),
        ]
        with m.If(move_measured):
            m.d.sync += [
                self.segments.valid.eq(measured),
                segment.x.eq(sides.x),
                segment.y.eq(sides.y),
                segment.west.eq(sides.west),
                segment.south.eq(sides.south),
                segment.steep.eq(steep),
                segment.steps.eq(Mux(steep, sides.along, sides.across)),
                segment.minor.eq(Mux(steep, sides.across, sides.along)),
                segment.altitude.eq(Mux(level & (sides.climb < 0), sides.goal, sides.altitude)),
                segment.climb.eq(sides.climb),
                segment.coarse.eq(sides.coarse),
                segment.number.eq(sides.number),
                segment.last.eq(sides.last),
            ]

        return m
