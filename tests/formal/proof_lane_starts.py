"""From their starts, the lanes of the parallel checker reach the cells of the definition."""

from amaranth import *
from amaranth.hdl import Assert, Cover

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.parallel.lanes import Slopes
from pathgene.hdl.feasibility.parallel.reciprocal import Precision
from pathgene.hdl.feasibility.parallel.segment_setup import SegmentSetup
from pathgene.hdl.feasibility.parallel.walker import ParallelWalker
from pathgene.hdl.layouts import point_layout
from tests.formal.parts import Opened, any_constant, made_of
from tools.formal import Proof


class Starts(Elaboratable):
    """Proved for each segment of a map of 8 x 8 cells and 16 altitudes, with 2 lanes.

    It is the first segment after reset; ``lane_set_up`` proves that every later segment gets the
    same, whatever preceded it. Therefore a proof over the 8 cycles of its set-up is enough. Start
    and stop are any two points; the walker is complete, with its reciprocals.

    - The segment reaches the lanes once.
    - For each cell k, where n is the length, d the gain along the minor axis and dz the gain in
      altitude: the start of the lane that has cell k, plus the gain of a group for each previous
      group, has as its integer parts ``floor((2 k d + n) / (2 n))`` from the start, and as the
      ceiling ``ceil(k dz / n)`` from the altitude of the start; for a segment of one cell, the
      lower end.
    """

    CYCLES = 8

    def __init__(self, unit):
        self.config = Config(map_size=8, coarse_factor=2, altitude_bits=4, max_waypoints=3, lanes=2)
        walker = made_of(ParallelWalker, SegmentSetup=unit(SegmentSetup), Slopes=unit(Slopes))
        self.dut = walker(self.config)

    def elaborate(self, platform):
        m = Module()
        walker, config = self.dut, self.config
        precision = Precision.of(config.lanes, config.coordinate_bits, config.altitude_bits)
        m.submodules.dut = dut = Opened(walker)
        lanes = dut.submodules.lanes
        launched, segment = lanes.launched, lanes.segment

        point = point_layout(config.coordinate_bits, config.altitude_bits)
        start, stop = (any_constant(m, point, name) for name in ("start", "stop"))
        k = any_constant(m, config.coordinate_bits, "k")
        cycle = Signal(range(self.CYCLES + 1))
        m.d.sync += cycle.eq(cycle + (cycle != self.CYCLES))
        m.d.comb += [
            walker.points.valid.eq(cycle < 2),
            walker.points.p.eq(Mux(cycle == 0, start.as_value(), stop.as_value())),
            walker.points.p.last.eq(cycle == 1),
            walker.room.eq(1),
            walker.segment_room.eq(1),
        ]

        lane, total = Signal(1), Signal(lanes.step.shape())
        group = Signal(config.coordinate_bits)
        m.d.comb += [
            lane.eq(segment.major + k),
            group.eq(k >> 1),
            *(
                total[axis].eq(Array(lanes.origins)[lane][axis] + group * lanes.step[axis])
                for axis in ("minor", "rise")
            ),
        ]
        n, steep = segment.length, segment.steep
        from_minor = Mux(steep, start.x, start.y)
        across = Mux(steep, stop.x, stop.y) - from_minor
        rise = stop.altitude - start.altitude
        minor = Signal(config.coordinate_bits)
        ceiling = Signal(config.altitude_bits)
        m.d.comb += [
            minor.eq(from_minor + _gain(n, across, k, _nearest)),
            ceiling.eq(start.altitude + _gain(n, rise, k, _ceiling)),
        ]
        launches = Signal(2)
        m.d.sync += launches.eq(launches + (launched.valid & launched.starts_segment))
        m.d.comb += Assert((cycle != self.CYCLES) | (launches == 1))
        with m.If(launched.valid & launched.starts_segment):
            with m.If(k <= n):
                m.d.comb += Assert(total.minor[precision.minor :] == minor)
                m.d.comb += Assert(total.rise[precision.rise :] == ceiling)
            m.d.comb += Cover((k == 6) & (n == 7) & (minor == 4) & steep & (ceiling == 5))
        return m


def _nearest(n, gain, k):
    return (2 * k * gain + n) // (2 * n) if n else 0


def _ceiling(n, gain, k):
    return -(-k * gain // n) if n else min(gain, 0)


def _gain(n, gain, k, definition):
    """Return ``definition`` of three signals from a table."""

    def chosen(signal, of):
        width = len(signal)
        values = [of(value) for value in range(1 << width)]
        for bit in signal:
            pairs = zip(values[::2], values[1::2], strict=True)
            values = [Mux(bit, odd, even) for even, odd in pairs]
        return values[0]

    half = 1 << len(gain) - 1
    return chosen(
        n,
        lambda length: chosen(
            k,
            lambda cell: chosen(
                gain,
                lambda code: Const(
                    definition(length, (code + half) % (2 * half) - half, cell), signed(8)
                ),
            ),
        ),
    )


PROOF = Proof(
    claim=Starts,
    depth=Starts.CYCLES + 1,
    reached=Starts.CYCLES,
    long=True,
    faults={
        "halves are rounded towards the start": (
            Slopes,
            (
                "Const(precision.minor_bias, precision.minor)",
                "Const(precision.minor_bias - 8, precision.minor)",
            ),
        ),
        "a step of one cell": (Slopes, ("shift - lane_bits", "shift")),
        "the upper end of a cell": (SegmentSetup, ("(rise < 0) &", "(rise > 0) &")),
    },
)
