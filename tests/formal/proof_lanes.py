"""The lanes of the parallel checker together visit each cell of a segment exactly once."""

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover
from amaranth.lib import data
from amaranth.utils import exact_log2

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.parallel.lanes import Lanes, motion_layout
from pathgene.hdl.feasibility.parallel.reciprocal import Precision
from tests.formal.parts import Opened, any_constant, free
from tools.formal import Proof


class Together(Elaboratable):
    """Proved for all time, by induction, for 4 lanes on a map of 8 x 8 cells.

    Segments between any two cells arrive at any time, with and without cycles in between. The
    claims of the proof ``lane_set_up`` are assumed: length, start, direction, place of each lane's
    first cell, and a token for each group. The lanes may start anywhere and move any distance in a
    cycle; ``lane_starts`` proves both correct.

    - An arbitrary cell k of the segment is visited in group k / lanes, by one lane, and at no other
      time, so the number of cells is the segment's.
    - The lane outputs the ``row`` of the cell's major coordinate and, for both other numbers, the
      integer part of the lane's start plus the gains of all previous groups.
    - Without a group, no lane has a cell.
    - Axis, direction, the major coordinate of the first cell, minor coordinates and number of
      cells of a group are reported in the same cycle.

    The induction is longer than any segment, because the registers of the lanes only depend on its
    start.
    """

    LANES, MAP_SIZE = 4, 8

    def __init__(self, unit):
        self.config = config = Config(
            lanes=self.LANES, map_size=self.MAP_SIZE, coarse_factor=2, altitude_bits=4
        )
        self.sizes = (config.lanes, config.coordinate_bits, config.altitude_bits)
        self.dut = unit(Lanes)(*self.sizes, config.segment_bits)

    def elaborate(self, platform):
        m = Module()
        lanes, config, count = self.dut, self.config, self.LANES
        m.submodules.dut = dut = Opened(lanes)
        launched, segment, precision = lanes.launched, lanes.segment, Precision.of(*self.sizes)
        fractions = {"minor": precision.minor, "rise": precision.rise}
        lane_bits = exact_log2(count)
        watched = any_constant(m, config.coordinate_bits, "watched")
        fields = (segment.steep, segment.descending, segment.length, segment.major)
        inputs = (*fields, lanes.step, *lanes.origins)
        free(m, *inputs)

        # Segments within the map, each lane's first cell along them, and their groups.
        begins, walking = Signal(), Signal()
        last, group = Signal(config.coordinate_bits), Signal(config.coordinate_bits)
        free(m, begins)
        stop = _at(segment.major, segment.descending, segment.length)
        m.d.comb += [
            Assume((stop >= 0) & (stop < config.map_size)),
            *(
                place.eq(_at(0, segment.descending, number - segment.major)[:lane_bits])
                for number, place in enumerate(segment.places)
            ),
            launched.valid.eq(begins | walking),
            launched.starts_segment.eq(begins & ~walking),
            launched.ends_segment.eq(
                Mux(walking, group == last, begins & (segment.length < count))
            ),
        ]
        with m.If(launched.starts_segment):
            m.d.sync += [last.eq(segment.length >> lane_bits), group.eq(1)]
        with m.Else():
            m.d.sync += group.eq(group + 1)
        with m.If(launched.valid):
            m.d.sync += walking.eq(~launched.ends_segment)

        # One cycle later: the segment whose group is in the lanes, and the number of the group.
        kept = [Signal.like(Value.cast(signal)) for signal in inputs]
        visits, here = Signal(), Signal.like(group)
        m.d.sync += [visits.eq(launched.valid), here.eq(Mux(walking, group, 0))]
        with m.If(launched.starts_segment):
            m.d.sync += [copy.eq(Value.cast(now)) for copy, now in zip(kept, inputs, strict=True)]
        steep, descending, length, major, *motions = kept
        step, *totals = (data.View(motion_layout(*self.sizes), motion) for motion in motions)
        with m.If(~launched.starts_segment):
            m.d.sync += [
                total[axis].eq(total[axis] + step[axis]) for total in totals for axis in fractions
            ]

        visitors = []
        for number, (lane, total) in enumerate(zip(lanes.lanes, totals, strict=True)):
            place, k = Signal(lane_bits), Signal(config.coordinate_bits + 1)
            x = Signal(config.coordinate_bits)
            m.d.comb += [
                place.eq(_at(0, descending, number - major)),
                k.eq(here * count + place),
                x.eq(_at(major, descending, k)),
                Assert(lane.valid == (visits & (k <= length))),
                Assert(lanes.group.minors[number] == lane.minor),
            ]
            with m.If(lane.valid):
                m.d.comb += Assert(lane.row * count + number == x)
                m.d.comb += [
                    Assert(lane.minor == total.minor[fractions["minor"] :]),
                    Assert(lane.ceiling == total.rise[fractions["rise"] :]),
                ]
                # Invariants that the induction needs, in addition to the previous groups.
                m.d.comb += Assert(dut.signal(f"motion_{number}") == total.as_value())
            cell = Signal(config.coordinate_bits)
            m.d.comb += cell.eq(lane.row * count + number)
            visitors.append(lane.valid & (cell == _at(major, descending, watched)))
        m.d.comb += Assert(
            sum(visitors) == (visits & (watched <= length) & (here == watched >> lane_bits))
        )
        with m.If(visits):
            m.d.comb += [
                Assert(lanes.group.steep == steep),
                Assert(lanes.group.descending == descending),
                Assert(lanes.group.major == _at(major, descending, here * count)),
                Assert(lanes.group.cells == sum(lane.valid for lane in lanes.lanes)),
            ]
        m.d.comb += Cover(
            visits & (here == (self.MAP_SIZE - 1) // count) & descending & (lanes.group.cells == 1)
        )
        return m


def _at(start, descending, k):
    return Mux(descending, start - k, start + k)


class TwoTogether(Together):
    """Proved for all time, by induction, as there, for 2 lanes on a map of 8 x 8 cells."""

    LANES, MAP_SIZE = 2, 8


class EightTogether(Together):
    """Proved for all time, by induction, as there, for 8 lanes on a map of 16 x 16 cells."""

    LANES, MAP_SIZE = 8, 16


FOUR = Proof(
    claim=Together,
    depth=4,
    induction=4,
    reached=8,
    faults={
        "the last group is always full": (
            Lanes,
            (
                "lane.valid.eq(token.valid & (in_last | ~token.ends_segment))",
                "lane.valid.eq(token.valid)",
            ),
        ),
        "a lane is left out of the last group": (
            Lanes,
            ("segment.places[number] <= rest_now", "segment.places[number] < rest_now"),
        ),
        "all lanes start in the same row": (
            Lanes,
            ("first > number if number < lane_count - 1 else 0", "0"),
        ),
        "a step of the segment before": (Lanes, ("step.eq(self.step)", "step.eq(step)")),
    },
)


PROOFS = {
    "lanes": FOUR,
    "lanes_2": Proof(TwoTogether, depth=6, reached=8, long=True, induction=6, faults=FOUR.faults),
    "lanes_8": Proof(EightTogether, depth=4, reached=8, long=True, induction=4, faults=FOUR.faults),
}
