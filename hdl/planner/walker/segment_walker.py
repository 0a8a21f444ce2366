"""Walker of segments: counts the corners that collide, and finds the minimum margin."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.feasibility.parallel.lanes import Lanes
from pathgene.hdl.feasibility.parallel.slopes import Slopes
from pathgene.hdl.feasibility.parallel.terrain_memory import TerrainMemory
from pathgene.hdl.layouts import cell_layout
from pathgene.hdl.planner.layouts import row_layout
from pathgene.hdl.planner.walker.layouts import (
    identity_layout,
    segment_request_layout,
    walked_layout,
)
from pathgene.hdl.planner.walker.margin_reducer import MarginReducer, reduction_latency
from pathgene.hdl.planner.walker.segment_launcher import SegmentLauncher
from pathgene.hdl.primitives.delay_line import delay_line
from pathgene.hdl.primitives.unit import Count, PowerOfTwo, Unit, Width


__all__ = ["SegmentWalker"]


class SegmentWalker(Unit):
    """Walks segments over the lattice of corners, ``lanes`` corners a cycle.

    Corners, altitudes, hits and margin equal
    :func:`pathgene.sim.model.planner.definition.walk.walk`. A segment of n corners takes n /
    ``lanes`` cycles, rounded up, and one that the memo has answered takes a cycle and reaches no
    corner; the next one follows right after. A segment is launched 2 cycles after it is taken, or
    later if segments before it are still being launched. ``walked`` follows the cycle of its last
    group by ``latency`` cycles: two for slopes and lanes, ``memory_latency + 3`` for the ground,
    and :func:`pathgene.hdl.planner.walker.margin_reducer.reduction_latency` to reduce it.

    The map is a :class:`TerrainMemory`, as in the parallel checker. While nothing is walked, the
    lanes' ports give a row of neighbouring corners a cycle.

    Source: *allaire two-tier*, section 5.3. Differs: corners, half steps, and margins.

    Attributes
    ----------
    latency, row_latency : int

    Members
    -------
    segments : In(stream.Signature(segment_request_layout))
    walked : Out(walked_layout)
        Results, in the order of the segments. There is no back-pressure.
    writes : In(stream.Signature(cell_layout))
        Corners of the map. They come only while no segment is walked.
    row : In(row_layout)
        Row of corners to be read, in any cycle in which no segment is offered or walked, and
        nothing is written.
    corners : Out(altitude_bits).array(lanes)
        Their altitudes, ``row_latency`` cycles later: a cycle to the map, and
        ``memory_latency + 3`` for the ground.
    """

    lanes: PowerOfTwo(1, "min(16, 1 << coordinate_bits)", "Corners walked in a cycle.")
    coordinate_bits: Width(1)
    altitude_bits: Width(1, text="The top altitude marks blocked corners.")
    row_bits: Width(1, text="Row of the memo.")
    memory_latency: Count(1, 2, "Cycles from an address to the data of the map's memory.")

    def interface(self):
        self.latency = 2 + self.memory_latency + 3 + reduction_latency(self.lanes)
        self.row_latency = 1 + self.memory_latency + 3
        sizes, identity = (self.coordinate_bits, self.altitude_bits), identity_layout(self.row_bits)
        return {
            "segments": In(stream.Signature(segment_request_layout(*sizes, identity))),
            "walked": Out(walked_layout(*sizes, identity)),
            "writes": In(stream.Signature(cell_layout(*sizes))),
            "row": In(row_layout(self.lanes, self.coordinate_bits)),
            "corners": Out(self.altitude_bits).array(self.lanes),
        }

    def elaborate(self, platform):
        m = Module()
        xy, z = self.coordinate_bits, self.altitude_bits
        answer = self.memory_latency + 3  # Cycles from a corner to its ground.

        m.submodules.launcher = launcher = SegmentLauncher(self.lanes, xy, z, self.row_bits)
        m.submodules.slopes = slopes = Slopes(self.lanes, xy, z, half_steps=True)
        m.submodules.lanes = lanes = Lanes(self.lanes, xy, z, 1, half_steps=True)
        m.submodules.terrain = terrain = TerrainMemory(
            self.lanes, xy, z, self.memory_latency, compare=False
        )
        m.submodules.reducer = reducer = MarginReducer(self.lanes, xy, z, self.row_bits)
        connect(m, flipped(self.segments), launcher.segments)

        # Answered segments have a token, and no corners.
        token, walks = launcher.token, Signal()
        m.d.sync += walks.eq(token.valid & ~token.identity.answered)
        for name in ("starts_segment", "ends_segment"):
            m.d.comb += lanes.launched[name].eq(delay_line(m, token[name], 1, name))
        m.d.comb += [
            slopes.segment.eq(launcher.segment),
            lanes.launched.valid.eq(walks),
            lanes.segment.eq(delay_line(m, launcher.segment, 1, "segment")),
            lanes.step.eq(slopes.step),
            *(into.eq(start) for into, start in zip(lanes.origins, slopes.origins, strict=True)),
        ]

        # Writes and rows cross the chip, too.
        writing = Signal()
        m.d.sync += writing.eq(self.writes.valid)
        m.d.comb += [
            terrain.steep.eq(lanes.group.steep),
            terrain.walking.eq(lanes.token.valid),
            self.writes.ready.eq(1),
            terrain.write_enable.eq(writing),
            *(
                getattr(terrain, f"write_{name}").eq(
                    delay_line(m, self.writes.p[name], 1, f"write_{name}")
                )
                for name in ("x", "y", "altitude")
            ),
            terrain.row_x.eq(delay_line(m, self.row.x, 1, "row_x")),
            terrain.row_y.eq(delay_line(m, self.row.y, 1, "row_y")),
            *(own.eq(of) for own, of in zip(self.corners, terrain.grounds, strict=True)),
        ]
        for number, lane in enumerate(lanes.lanes):
            altitude = delay_line(m, lane.ceiling, answer, f"altitude_{number}")
            m.d.comb += [
                terrain.lanes[number].eq(lane),
                reducer.altitudes[number].eq(altitude),
                reducer.grounds[number].eq(terrain.grounds[number]),
                reducer.valid[number].eq(delay_line(m, lane.valid, answer, f"valid_{number}")),
            ]

        # The token waits for slopes, lanes and ground.
        valid = token.valid
        for cycle in range(1, answer + 3):
            earlier = Signal(name=f"token_{cycle}")
            m.d.sync += earlier.eq(valid)
            valid = earlier
        m.d.comb += [
            reducer.token.valid.eq(valid),
            *(
                reducer.token[name].eq(delay_line(m, token[name], answer + 2, name))
                for name in ("starts_segment", "ends_segment", "identity")
            ),
            self.walked.eq(reducer.walked),
        ]

        return m
