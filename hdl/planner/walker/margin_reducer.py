"""Hits and minimum margin of a segment, from its corners."""

from amaranth import *
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.planner.walker.layouts import identity_layout, walked_layout
from pathgene.hdl.planner.walker.segment_launcher import launch_layout
from pathgene.hdl.primitives.delay_line import delay_line
from pathgene.hdl.primitives.unit import PowerOfTwo, Unit, Width


__all__ = ["MarginReducer", "reduction_latency"]


def reduction_latency(lanes: int) -> int:
    """Return the cycles that a :class:`MarginReducer` takes.

    One for the margin of each corner, one for each level of a tree over the lanes, one to add the
    group to the previous groups.
    """
    return 2 + exact_log2(lanes)


class MarginReducer(Unit):
    """Counts the corners of a segment that collide, and finds its minimum margin.

    The margin of a corner is the altitude of the segment above the ground there. A corner whose
    ground has the top altitude is blocked: it collides and has no margin. A segment without margins
    has the top altitude as its margin. ``walked`` follows the last group of its segment by
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
