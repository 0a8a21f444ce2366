"""Walker of segments: launch, lanes over the corners, minimum margin."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import exact_log2

from pathgene.hdl.feasibility.parallel.lanes import Lanes, Slopes
from pathgene.hdl.feasibility.parallel.reciprocal import Precision, Reciprocals
from pathgene.hdl.feasibility.parallel.segment_setup import SegmentShaper, segment_layout
from pathgene.hdl.feasibility.parallel.terrain_memory import TerrainMemory
from pathgene.hdl.layouts import cell_layout
from pathgene.hdl.planner.layouts import row_layout
from pathgene.hdl.planner.walker.layouts import (
    corner_layout,
    identity_layout,
    segment_request_layout,
    walked_layout,
)
from pathgene.hdl.primitives.logic import delay_line, fanout
from pathgene.hdl.primitives.unit import Count, PowerOfTwo, Unit, Width


__all__ = [
    "MarginReducer",
    "SegmentLauncher",
    "SegmentWalker",
    "launch_layout",
    "reduction_latency",
]


def launch_layout(identity: data.StructLayout) -> data.StructLayout:
    """Return the layout of the data that accompanies a group of corners through the pipeline.

    ``valid``, ``starts_segment``, ``ends_segment``, and the ``identity`` of its segment.
    """
    return data.StructLayout(
        {"valid": 1, "starts_segment": 1, "ends_segment": 1, "identity": identity}
    )


class SegmentLauncher(SegmentShaper):
    """Launches segments back to back.

    A segment waits in two stages, as in
    :class:`pathgene.hdl.feasibility.parallel.segment_setup.SegmentSetup`. The second stage launches
    it: one group of corners per cycle, or a single empty group if the memo answers for it. Then the
    next segment follows. Nothing after this unit waits. A segment is launched 2 cycles after it is
    taken, or later if earlier segments are still being launched.

    Members
    -------
    segments : In(stream.Signature(segment_request_layout))
    token : Out(launch_layout)
        The group that is launched.
    segment : Out(segment_layout)
        With ``token.starts_segment``.
    """

    row_bits: Width(1, text="Row of the memo.")

    half_steps = True

    def interface(self):
        self.point_layout = corner_layout(self.coordinate_bits, self.altitude_bits)
        self.identity_layout = identity_layout(self.row_bits)
        sizes = (self.coordinate_bits, self.altitude_bits)
        request = segment_request_layout(*sizes, self.identity_layout)
        return {
            "segments": In(stream.Signature(request)),
            "token": Out(launch_layout(self.identity_layout)),
            "segment": Out(segment_layout(self.lanes, *sizes, half_steps=True)),
        }

    def elaborate(self, platform):
        m = Module()
        request = self.segments.p

        # Whether the stages hold a segment, and whether the last group of a segment has been
        # launched, with separate registers for the wider stage.
        waiting_next, free_next = Signal(), Signal()
        has_waiting, waiting_full = fanout(m, *[waiting_next] * 2, name="waiting")
        free, freed = fanout(m, *[free_next] * 2, name="free", init=1)
        has_measured = Signal()
        load, move_on, launch = Signal(), Signal(), Signal()
        m.submodules.reciprocals = reciprocals = Reciprocals(
            self.coordinate_bits,
            Precision.of(self.lanes, self.coordinate_bits, self.altitude_bits, half_steps=True),
        )
        m.d.comb += [
            load.eq(~has_measured | ~waiting_full | freed),
            move_on.eq(~has_waiting | free),
            launch.eq(has_waiting & free),
            self.segments.ready.eq(load),
            reciprocals.load.eq(load),
            reciprocals.move.eq(move_on),
            waiting_next.eq(Mux(move_on, has_measured, has_waiting)),
        ]
        with m.If(load):
            m.d.sync += has_measured.eq(self.segments.valid)

        measured = Signal(self.identity_layout, reset_less=True)
        waiting = Signal(self.identity_layout, reset_less=True)
        # Signs of the sum and difference of the gains.
        x, y = (request.stop[axis] - request.start[axis] for axis in "xy")
        sides = self._measure(
            m,
            load,
            request.start,
            request.stop,
            [(y + x)[-1], (y - x)[-1]],
            reciprocals,
            [measured.eq(request.identity)],
        )
        shape = self._shape(m, move_on, sides)
        with m.If(move_on):
            m.d.sync += waiting.eq(measured)
        m.d.comb += [
            self.segment.reciprocal.eq(reciprocals.reciprocal),
            *(self.segment[name].eq(shape[name]) for name, _ in shape.shape()),
        ]

        token = self.token
        left = Signal(self.coordinate_bits)  # Groups left of the segment launched last.
        launched = Signal(self.identity_layout, reset_less=True)
        groups = Mux(waiting.answered, 0, shape.length >> exact_log2(self.lanes))
        m.d.comb += token.valid.eq(launch | ~free)
        with m.If(launch):
            m.d.sync += [left.eq(groups), launched.eq(waiting)]
            m.d.comb += [
                free_next.eq(groups == 0),
                token.starts_segment.eq(1),
                token.ends_segment.eq(groups == 0),
                token.identity.eq(waiting),
            ]
        with m.Else():
            m.d.sync += left.eq(left - ~free)
            m.d.comb += [
                free_next.eq(left <= 1),
                token.ends_segment.eq(left == 1),
                token.identity.eq(launched),
            ]

        return m


def reduction_latency(lanes: int) -> int:
    """Return the latency of a :class:`MarginReducer` in cycles.

    It takes one cycle for the margin of each corner, one for each level of a tree over the lanes,
    and one to add the group to the previous groups.
    """
    return 2 + exact_log2(lanes)


class MarginReducer(Unit):
    """Counts the colliding corners of a segment, and finds its minimum margin.

    The margin of a corner is the altitude of the segment above the ground there. A corner whose
    ground has the top altitude is blocked: it collides and has no margin. The margin of a segment
    without margins is the top altitude. ``walked`` follows the last group of its segment by
    :func:`reduction_latency`.

    Members
    -------
    token : In(launch_layout)
    valid : In(lanes)
        Lanes that have a corner.
    altitudes, grounds : In(altitude_bits).array(lanes)
        Altitude of the segment and of the ground, at the corner of each lane.
    walked : Out(walked_layout)
    """

    lanes: PowerOfTwo(1, 16, "Corners of a group.")
    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    row_bits: Width(1, text="Row of the memo.")

    def interface(self):
        identity = identity_layout(self.row_bits)
        each = In(self.altitude_bits).array(self.lanes)
        return {
            "token": In(launch_layout(identity)),
            "valid": In(self.lanes),
            "altitudes": each,
            "grounds": each,
            "walked": Out(walked_layout(self.coordinate_bits, self.altitude_bits, identity)),
        }

    def elaborate(self, platform):
        m = Module()
        z, walked, latency = self.altitude_bits, self.walked, reduction_latency(self.lanes)
        top = (1 << z) - 1

        margins, counts = [], []
        for lane in range(self.lanes):
            margin = Signal(signed(z + 1), name=f"margin_{lane}", reset_less=True)
            hit = Signal(name=f"hit_{lane}", reset_less=True)
            above, blocked = Signal(signed(z + 1), name=f"above_{lane}"), Signal(name=f"top_{lane}")
            ground = self.grounds[lane]
            m.d.comb += [above.eq(self.altitudes[lane] - ground), blocked.eq(ground == top)]
            m.d.sync += [
                margin.eq(Mux(self.valid[lane] & ~blocked, above, top)),
                hit.eq(self.valid[lane] & (blocked | (above < 0))),
            ]
            margins.append(margin)
            counts.append(hit)

        level = 0
        while len(margins) > 1:
            pairs = [
                (margins[at : at + 2], counts[at : at + 2]) for at in range(0, len(margins), 2)
            ]
            margins, counts = [], []
            for number, (margin, count) in enumerate(pairs):
                least = Signal(signed(z + 1), name=f"least_{level}_{number}", reset_less=True)
                total = Signal(level + 2, name=f"total_{level}_{number}", reset_less=True)
                m.d.sync += [least.eq(_least(*margin)), total.eq(sum(count))]
                margins.append(least)
                counts.append(total)
            level += 1

        is_start = delay_line(m, self.token.starts_segment, latency - 1, "is_start")
        identity = delay_line(m, self.token.identity, latency, "identity")
        ends = self.token.valid & self.token.ends_segment
        for cycle in range(1, latency):
            earlier = Signal(name=f"ends_{cycle}")
            m.d.sync += earlier.eq(ends)
            ends = earlier
        hits = Signal.like(walked.hits, reset_less=True)
        least = Signal.like(walked.margin, reset_less=True)
        m.d.sync += [
            walked.valid.eq(ends),
            hits.eq(Mux(is_start, 0, hits) + counts[0]),
            least.eq(Mux(is_start, margins[0], _least(least, margins[0]))),
        ]
        m.d.comb += [
            walked.hits.eq(hits),
            walked.margin.eq(least),
            walked.identity.eq(identity),
        ]

        return m


def _least(first, second):
    return Mux(first < second, first, second)


class SegmentWalker(Unit):
    """Walks segments over the lattice of corners, ``lanes`` corners per cycle.

    Corners, altitudes, hits and margin equal
    :func:`pathgene.sim.model.planner.definition.score.walk`. A segment of n corners takes n /
    ``lanes`` cycles, rounded up; a segment that the memo has answered takes one cycle and reads no
    corner; the next segment follows without a gap. A segment is launched 2 cycles after it is
    taken, or later if earlier segments are still being launched. ``walked`` follows the cycle of
    its last group by ``latency`` cycles: two for slopes and lanes, ``memory_latency + 3`` for the
    ground, and :func:`pathgene.hdl.planner.walker.segment_walker.reduction_latency` to reduce it.

    The map is a :class:`TerrainMemory`, as in the parallel checker. While nothing is walked, the
    lanes' ports read a row of neighbouring corners per cycle.

    Source: *allaire two-tier*, section 5.3. Differences: corners, half steps, and margins.

    Attributes
    ----------
    latency, row_latency : int

    Members
    -------
    segments : In(stream.Signature(segment_request_layout))
    walked : Out(walked_layout)
        Results, in the order of the segments. There is no back-pressure.
    writes : In(stream.Signature(cell_layout))
        Corners of the map. They only arrive while no segment is walked.
    row : In(row_layout)
        Row of corners to read, in any cycle in which no segment is offered or walked and nothing is
        written.
    corners : Out(altitude_bits).array(lanes)
        Their altitudes, ``row_latency`` cycles later: one cycle to the map, and
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

        # Answered segments have a token but no corners.
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

        # Writes and rows cross the chip as well.
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
