"""The parallel checker's lanes receive each segment of the paths, unchanged and in order."""

from amaranth import *
from amaranth.hdl import Assert, Cover
from amaranth.utils import exact_log2

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.parallel.lanes import Slopes
from pathgene.hdl.feasibility.parallel.reciprocal import Precision
from pathgene.hdl.feasibility.parallel.segment_setup import SegmentSetup
from pathgene.hdl.feasibility.parallel.walker import ParallelWalker
from pathgene.hdl.layouts import point_layout
from tests.formal.parts import Opened, Segment, any_constant, free, made_of
from tools.formal import Proof


#: Stands for a multiplier, of which only the inputs matter here.
MIXED = (
    "_registered(m, factor, _signed(reciprocal), shift, name)",
    "delay_line(m, factor ^ _signed(reciprocal), 1, name)",
)


class SetUpInOrder(Elaboratable):
    """Proved for the first 9 cycles from reset, for 2 lanes on 8 x 8 cells of 16 altitudes.

    That is long enough for 4 segments of one group each, or for a longer segment that keeps later
    ones waiting. Points arrive at any time, paths have any number of points, and there may or may
    not be room for results. Assumed: no path is dropped. The walker is complete, except that its
    multipliers compute a simpler function of both factors; ``lane_starts`` proves the use of the
    products.

    - Segments reach the lanes in the order of their points, each once: with its start, its axis,
      its direction and its length. The axis is the one along the longer side; if the sides are
      equal, it may be either, because the cells are the same.
    - ``places`` has, for each lane, the first cell along the segment whose major coordinate is
      congruent to the lane's number modulo the number of lanes.
    - It is accompanied by the products, for its minor coordinate and altitude, of the reciprocal of
      its length with its gain and with the gains up to these places.
    - A segment has one token for each group of as many cells as there are lanes, in consecutive
      cycles, and the last token ends the segment. There are no other tokens.
    """

    def __init__(self, unit):
        self.config = Config(map_size=8, coarse_factor=2, altitude_bits=4, max_waypoints=3, lanes=2)
        walker = made_of(
            ParallelWalker, SegmentSetup=unit(SegmentSetup), Slopes=unit(Slopes, MIXED)
        )
        self.dut = walker(self.config)

    def elaborate(self, platform):
        m = Module()
        walker, config = self.dut, self.config
        precision = Precision.of(config.lanes, config.coordinate_bits, config.altitude_bits)
        lane_bits = exact_log2(config.lanes)
        m.submodules.dut = dut = Opened(walker)
        lanes = dut.submodules.lanes
        launched, segment = lanes.launched, lanes.segment
        points, point = walker.points, walker.points.p
        free(m, points.valid, point.x, point.y, point.altitude, point.last)
        free(m, walker.room, walker.segment_room)

        # The watched segment, an arbitrary one, as its points arrive.
        watched = any_constant(m, 3, "watched")
        layout = point_layout(config.coordinate_bits, config.altitude_bits)
        before, inside, number, known = Signal(layout), Signal(), Signal(3), Signal()
        start, stop = (Signal(layout, name=name) for name in ("start", "stop"))
        with m.If(points.valid & points.ready):
            m.d.sync += [before.eq(point), inside.eq(~point.last)]
            with m.If(inside):
                m.d.sync += number.eq(number + 1)
                with m.If(~known & (number == watched)):
                    m.d.sync += [start.eq(before), stop.eq(point), known.eq(1)]
        expected = Segment(m, start, stop)
        n = expected.length

        # The segment launched, and its groups.
        launches, left = Signal(3), Signal(config.coordinate_bits)
        begins, here = Signal(), Signal()
        groups = segment.length >> lane_bits
        m.d.comb += [
            begins.eq(launched.valid & launched.starts_segment),
            here.eq(begins & (launches == watched)),
            Assert(launched.valid == (begins | (left != 0))),
            Assert(~begins | (left == 0)),
        ]
        with m.If(begins):
            m.d.sync += [left.eq(groups), launches.eq(launches + 1)]
            m.d.comb += Assert(launched.ends_segment == (groups == 0))
        with m.Elif(left != 0):
            m.d.sync += left.eq(left - 1)
            m.d.comb += Assert(launched.ends_segment == (left == 1))

        # The values that accompany it.
        steep = segment.steep
        gain, across = (
            Signal(signed(config.coordinate_bits + 1), name=name) for name in ("gain", "across")
        )
        reciprocal = Signal(signed(precision.reciprocal + 1))
        lengths = Array(precision.of_length(length) for length in range(config.map_size))
        m.d.comb += [
            gain.eq(Mux(steep, expected.gain["y"], expected.gain["x"])),
            across.eq(Mux(steep, expected.gain["x"], expected.gain["y"])),
            reciprocal.eq(lengths[n]),
        ]
        with m.If(here):
            m.d.comb += [
                Assert(known),
                Assert(Mux(steep, expected.side["y"], expected.side["x"]) == n),
                Assert(segment.length == n),
                Assert(segment.major == Mux(steep, start.y, start.x)),
                Assert(segment.descending == (gain < 0)),
                Cover((watched == 1) & (n == 5) & (gain < 0) & steep & (across == 3)),
            ]
            for lane, place in enumerate(segment.places):
                away = Mux(gain < 0, segment.major - lane, lane - segment.major)
                m.d.comb += Assert(place == away[:lane_bits])
            for axis, difference, first, fraction, bias in (
                (
                    "minor",
                    across,
                    Mux(steep, start.x, start.y),
                    precision.minor,
                    precision.minor_bias,
                ),
                (
                    "rise",
                    expected.rise,
                    expected_altitude(expected),
                    precision.rise,
                    precision.rise_bias,
                ),
            ):
                m.d.comb += Assert(
                    lanes.step[axis] == (difference ^ reciprocal)[: len(lanes.step[axis])]
                )
                for place, motion in zip(segment.places, lanes.origins, strict=True):
                    product = (place[:lane_bits] * difference) ^ reciprocal
                    total = product + (first << fraction) + bias
                    m.d.comb += Assert(motion[axis] == total[: len(motion[axis])])
        return m


def expected_altitude(segment):
    """Return the altitude from which a segment climbs: the lower one if it has one cell."""
    return Mux(segment.length == 0, segment.lowest(), segment.start.altitude)


PROOF = Proof(
    claim=SetUpInOrder,
    depth=9,
    reached=9,
    long=True,
    faults={
        "the start of the next segment": (
            SegmentSetup,
            ("ends[0].eq(before)", "ends[0].eq(point)"),
        ),
        "a group too few": (SegmentSetup, ("free_next.eq(left <= 1)", "free_next.eq(left <= 2)")),
        "lanes take the wrong places": (
            SegmentSetup,
            ("start.eq(Mux(steep, ends[0].y, ends[0].x))", "start.eq(ends[0].x)"),
        ),
        "a segment overtakes": (SegmentSetup, ("has_waiting & free", "has_waiting")),
    },
)
