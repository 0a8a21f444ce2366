"""Bresenham walker of the two-tier build: one cell per cycle, without a divider."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.feasibility.two_tier.segment_setup import segment_layout
from pathgene.hdl.primitives.unit import Unit, Width


__all__ = ["CellWalker", "level_layout", "visit_layout"]


def visit_layout(coordinate_bits: int, segment_bits: int) -> data.StructLayout:
    """Return the layout of one visited cell, in cells of its map, and its place in the path.

    ``coarse``: its map is the coarse one. ``segment``: number of its segment. ``first``: it is the
    first cell of its path; ``ends_segment`` and ``ends_path``: it is the last one of these.
    """
    return data.StructLayout(
        {
            "x": coordinate_bits,
            "y": coordinate_bits,
            "coarse": 1,
            "segment": segment_bits,
            "first": 1,
            "ends_segment": 1,
            "ends_path": 1,
        }
    )


def level_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of an altitude: the exact quotient ``scaled / steps``, ``steps`` not 0."""
    return data.StructLayout({"scaled": altitude_bits + coordinate_bits, "steps": coordinate_bits})


class CellWalker(Unit):
    """Visits every cell of segments, both ends included, in walking order.

    Cell k of a segment of n steps is ``x0 + floor((2 k dx + n) / (2 n))``, y likewise. Each step
    moves one cell along the longer side. Along the shorter side, an error between -2 n and -1 grows
    by twice that side in each step, and the walker moves one cell when the error reaches 0. Halves
    are rounded up, not away from the start: towards lower coordinates the error begins one lower.
    The altitude is the exact ``(z0 n + k dz) / n``, its numerator summed up step by step; a segment
    without steps counts as a single step, of which only the first cell is visited.

    The first cell is visited in the cycle after its segment is taken, then one cell per cycle. The
    next segment is taken in the last of these cycles, so that no cycle is lost.

    Source: *allaire two-tier*, section 3.2.3. Differs: the next segment is set up during the walk.

    Members
    -------
    segments : In(stream.Signature(segment_layout))
    room : In(1)
        The first segment of a path may be taken.
    segment_room : In(1)
        A segment may be taken.
    begins : Out(1)
        The first segment of a path is taken.
    segment_begins : Out(1)
        A segment is taken to be walked.
    drop : In(1)
        Leave the path of the latest visited cell, starting in the next cycle; that cell must not
        have been its last. A cell may still be visited in the cycle of ``drop``; it is void. Later
        segments of the path are taken and not walked, one per cycle.
    visiting : Out(1)
        ``visit`` is visited in this cycle.
    visit : Out(visit_layout)
        A register.
    level : Out(level_layout)
        Altitude at the cell that was visited in the previous cycle.
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    segment_bits: Width(1, text="Number of a segment in its path.")

    def interface(self):
        segments = segment_layout(self.coordinate_bits, self.altitude_bits, self.segment_bits)
        return {
            "segments": In(stream.Signature(segments)),
            "room": In(1),
            "segment_room": In(1),
            "begins": Out(1),
            "segment_begins": Out(1),
            "drop": In(1),
            "visiting": Out(1),
            "visit": Out(visit_layout(self.coordinate_bits, self.segment_bits)),
            "level": Out(level_layout(self.coordinate_bits, self.altitude_bits)),
        }

    def elaborate(self, platform):
        m = Module()
        xy = self.coordinate_bits

        segment = self.segments.p
        active = Signal()
        dropping = Signal()
        # The present segment.
        last = Signal()
        west = Signal()
        south = Signal()
        steep = Signal()
        left = Signal(xy)
        error = Signal(signed(xy + 2))
        growth = Signal(xy + 1)
        excess = Signal(signed(xy + 2))

        visit = self.visit
        opens = Signal()
        ended = Signal()
        free = Signal()
        load = Signal()
        m.d.comb += [
            opens.eq(segment.number == 0),
            ended.eq(left == 0),
            self.visiting.eq(active),
            visit.ends_segment.eq(ended),
            visit.ends_path.eq(ended & last),
            free.eq(~active | ended),
            self.segments.ready.eq(
                dropping | (free & ~self.drop & self.segment_room & (self.room | ~opens))
            ),
            load.eq(self.segments.valid & self.segments.ready & ~dropping),
            self.begins.eq(load & opens),
            self.segment_begins.eq(load),
        ]

        with m.If(self.drop):
            m.d.sync += dropping.eq(~(active & last))
        with m.Elif(dropping & self.segments.valid & segment.last):
            m.d.sync += dropping.eq(0)

        with m.If(self.drop):
            m.d.sync += active.eq(0)
        with m.Elif(free):
            m.d.sync += active.eq(load)

        grown = Signal(signed(xy + 2))
        across = Signal()  # A step along the shorter side.
        m.d.comb += [grown.eq(error + growth), across.eq(grown >= 0)]
        with m.If(load):
            m.d.sync += [
                visit.x.eq(segment.x),
                visit.y.eq(segment.y),
                visit.coarse.eq(segment.coarse),
                visit.segment.eq(segment.number),
                visit.first.eq(opens),
                last.eq(segment.last),
                west.eq(segment.west),
                south.eq(segment.south),
                steep.eq(segment.steep),
                left.eq(segment.steps),
                # n - 2 n, and one lower where steps go towards 0.
                error.eq(-segment.steps - Mux(segment.steep, segment.west, segment.south)),
                growth.eq(segment.minor << 1),
                excess.eq((segment.minor - segment.steps) << 1),
            ]
        with m.Elif(active):
            m.d.sync += [
                visit.first.eq(0),
                left.eq(left - 1),
                error.eq(Mux(across, error + excess, grown)),
            ]
            with m.If(steep | across):
                m.d.sync += visit.y.eq(Mux(south, visit.y - 1, visit.y + 1))
            with m.If(~steep | across):
                m.d.sync += visit.x.eq(Mux(west, visit.x - 1, visit.x + 1))

        # The altitude follows a cycle later, so that the product of a new segment has a cycle.
        steps = Signal(xy)
        climb = Signal(signed(self.altitude_bits + 1))
        scaled_start = Signal(self.level.scaled.shape())
        begins = Signal()
        with m.If(load):
            divisor = Mux(segment.steps == 0, 1, segment.steps)
            m.d.sync += [
                begins.eq(1),
                steps.eq(divisor),
                climb.eq(segment.climb),
                scaled_start.eq(segment.altitude * divisor),
            ]
        with m.Else():
            m.d.sync += begins.eq(0)
        with m.If(active):
            m.d.sync += [
                self.level.scaled.eq(Mux(begins, scaled_start, self.level.scaled + climb)),
                self.level.steps.eq(steps),
            ]

        return m
