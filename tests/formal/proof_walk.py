"""The sequential walker visits exactly the cells of the definition."""

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.two_tier.cell_walker import CellWalker
from pathgene.hdl.layouts import point_layout
from tests.formal.parts import Opened, Segment, free
from tools.formal import Proof


class Walk(Elaboratable):
    """Proved for all time, by induction, for 8 x 8 cells of 16 altitudes.

    Segments between any two points arrive and may be taken at any time. Assumed: they are set up
    correctly, and no path is dropped.

    - Cell k of the walk is cell k of the definition, one per cycle from the cycle after the segment
      was taken; after cell n, which is marked as the last, the walk is done: no cell is missing or
      visited twice.
    - One cycle later, the altitude is the exact ``(z0 n + k dz) / n``, or the altitude from the
      set-up for a segment of one cell.
    """

    def __init__(self, unit):
        self.config = config = Config(
            map_size=8,
            coarse_factor=2,
            altitude_bits=4,
            max_waypoints=3,
            checker="two-tier",
            lanes=1,
        )
        self.dut = unit(CellWalker)(
            config.coordinate_bits, config.altitude_bits, config.segment_bits
        )

    def elaborate(self, platform):
        m = Module()
        walker, config = self.dut, self.config
        m.submodules.dut = dut = Opened(walker)
        offer, visit = walker.segments.p, walker.visit
        free(m, walker.segments.valid, walker.room, walker.segment_room)

        # A segment as the set-up must make it.
        point = point_layout(config.coordinate_bits, config.altitude_bits)
        offered = [Signal(point, name=name) for name in ("offered", "offered_end")]
        free(m, *offered, offer.coarse, offer.number, offer.last)
        new = Segment(m, *offered)
        m.d.comb += [
            offer.x.eq(new.start.x),
            offer.y.eq(new.start.y),
            offer.west.eq(new.gain["x"] < 0),
            offer.south.eq(new.gain["y"] < 0),
            offer.steep.eq(new.steep),
            offer.steps.eq(new.length),
            offer.minor.eq(Mux(new.steep, new.side["x"], new.side["y"])),
            offer.altitude.eq(Mux(new.length == 0, new.lowest(), new.start.altitude)),
            offer.climb.eq(new.rise),
        ]

        # The segment being walked, and which of its cells is the next.
        points = [Signal(point, name=name) for name in ("start", "stop")]
        segment = Segment(m, *points)
        n = segment.length
        active, k = Signal(), Signal(4)
        taken = Signal()
        m.d.comb += taken.eq(walker.segments.valid & walker.segments.ready)
        with m.If(taken):
            m.d.sync += [point.eq(new) for point, new in zip(points, offered, strict=True)]
            m.d.sync += [active.eq(1), k.eq(0)]
        with m.Elif(active):
            m.d.sync += [active.eq(k != n), k.eq(k + 1)]

        m.d.comb += [
            Assert(walker.visiting == active),
            Assert(~taken | ~active | (k == n)),
            Assert(walker.segment_begins == taken),
        ]
        with m.If(active):
            m.d.comb += [
                Assert(k <= n),
                Assert(visit.ends_segment == (k == n)),
                Assert(segment.is_at("x", k, visit.x) & segment.is_at("y", k, visit.y)),
            ]

        # The altitude of the previous cell.
        visited = Signal()
        scaled = Signal(signed(12))
        steps = Signal(config.coordinate_bits)
        m.d.sync += visited.eq(active)
        with m.If(active):
            level = Mux(n == 0, segment.lowest(), segment.start.altitude * n + k * segment.rise)
            m.d.sync += [scaled.eq(level), steps.eq(Mux(n == 0, 1, n))]
        with m.If(visited):
            m.d.comb += [
                Assert(walker.level.scaled == scaled),
                Assert(walker.level.steps == steps),
            ]

        # Invariant that the induction needs: the error follows from the steps along the shorter
        # side.
        gain = {a: segment.gain[a] for a in "xy"}
        minor = Mux(segment.steep, segment.side["x"], segment.side["y"])
        down = Mux(segment.steep, gain["x"], gain["y"]) < 0
        crossed = Mux(segment.steep, visit.x - segment.start.x, visit.y - segment.start.y)
        crossed = Mux(down, -crossed, crossed)
        begins = dut.signal("begins", "sync")
        m.d.comb += Assert(~dut.signal("dropping"))
        with m.If(active):
            m.d.comb += [
                Assert(dut.signal("left") == n - k),
                Assert(dut.signal("steep") == segment.steep),
                Assert(dut.signal("west") == (gain["x"] < 0)),
                Assert(dut.signal("south") == (gain["y"] < 0)),
                Assert(dut.signal("growth") == 2 * minor),
                Assert(dut.signal("excess") == 2 * minor - 2 * n),
                Assert(dut.signal("error") == 2 * k * minor - 2 * n * crossed - n - down),
                Assert(dut.signal("steps") == Mux(n == 0, 1, n)),
                Assert(dut.signal("climb") == segment.rise),
                Assert(begins == (k == 0)),
            ]
            with m.If(k == 0):
                level = Mux(n == 0, segment.lowest(), segment.start.altitude * n)
                m.d.comb += Assert(dut.signal("scaled_start") == level)
            with m.Else():
                level = segment.start.altitude * n + (k - 1) * segment.rise
                m.d.comb += [Assert(visited), Assert(walker.level.scaled == level)]

        walks = Signal(2)
        m.d.sync += walks.eq(walks + taken)
        m.d.comb += [
            Assume(~walker.drop),
            Cover((walks == 2) & active & (k == 7) & (minor == 4) & down & segment.steep),
        ]
        return m


PROOF = Proof(
    claim=Walk,
    depth=2,
    reached=14,
    long=True,
    induction=2,
    faults={
        "halves are rounded away from the start": (
            CellWalker,
            (
                "error.eq(-segment.steps - Mux(segment.steep, segment.west, segment.south))",
                "error.eq(-segment.steps)",
            ),
        ),
        "a step too early": (CellWalker, ("across.eq(grown >= 0)", "across.eq(grown >= -1)")),
        "the last cell is missing": (
            CellWalker,
            ("ended.eq(left == 0)", "ended.eq(left <= 1)"),
        ),
        "a step along the wrong side": (
            CellWalker,
            ("with m.If(steep | across):", "with m.If(~steep | across):"),
        ),
    },
)
