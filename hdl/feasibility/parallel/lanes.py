"""Lanes, which walk a group of neighbouring cells of a segment each cycle."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.feasibility.parallel.reciprocal import Precision
from pathgene.hdl.feasibility.parallel.segment_setup import segment_layout, token_layout
from pathgene.hdl.feasibility.parallel.slopes import motion_layout
from pathgene.hdl.feasibility.parallel.terrain_memory import lane_layout, lane_row_bits
from pathgene.hdl.primitives.unit import Flag, PowerOfTwo, Unit, Width


__all__ = ["Lanes", "group_layout"]


def group_layout(lanes: int, coordinate_bits: int) -> data.StructLayout:
    """Return the layout of a group: the cells of one cycle.

    ``steep``, ``descending`` as of its segment; ``major`` (of its first cell), ``minors`` (of all
    lanes), ``cells`` (how many it has).
    """
    return data.StructLayout(
        {
            "steep": 1,
            "descending": 1,
            "major": coordinate_bits,
            "minors": data.ArrayLayout(coordinate_bits, lanes),
            "cells": range(lanes + 1),
        }
    )


class Lanes(Unit):
    """Walks segments, ``lane_count`` cells per cycle.

    Lane c has the cells whose major coordinate is c mod ``lane_count``. Its cell in the first group
    depends on the start of the segment, so that each group but the last is full: a segment of n
    cells takes n / ``lane_count`` cycles, rounded up. The following cells are sums: every lane
    gains the same in a cycle, see :class:`pathgene.hdl.feasibility.parallel.reciprocal.Precision`.

    ``group`` and ``lanes`` follow their token in ``launched`` by a cycle.

    Source: *allaire two-tier*, section 5.3. Differs: its reference has several walkers, each with a
    part of the segment.

    Members
    -------
    launched : In(token_layout)
    segment : In(segment_layout)
    origins : In(motion_layout).array(lane_count)
    step : In(motion_layout)
        First cells and gain of the segment that ``launched`` starts.
    token : Out(token_layout)
        ``launched``, a cycle later.
    group : Out(group_layout)
    lanes : Out(lane_layout).array(lane_count)
    """

    lane_count: PowerOfTwo(1, "1 << coordinate_bits", "Cells walked in a cycle.", name="Lanes")
    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    segment_bits: Width(1, text="Number of a segment in its path.")
    half_steps: Flag(
        "Each ``ceiling`` is the lowest altitude within half a step of the cell, rounded "
        "down, and never below the lower end. Only the cell at the lower end can lie below "
        "it: that cell takes the altitude of the end."
    ) = False

    def interface(self):
        sizes = (self.lane_count, self.coordinate_bits, self.altitude_bits)
        token, motion = token_layout(self.segment_bits), motion_layout(*sizes, self.half_steps)
        return {
            "launched": In(token),
            "segment": In(segment_layout(*sizes, self.half_steps)),
            "origins": In(motion).array(self.lane_count),
            "step": In(motion),
            "token": Out(token),
            "group": Out(group_layout(self.lane_count, self.coordinate_bits)),
            "lanes": Out(lane_layout(*sizes)).array(self.lane_count),
        }

    def elaborate(self, platform):
        m = Module()
        lane_count, segment, token = self.lane_count, self.segment, self.token
        precision = Precision.of(
            lane_count, self.coordinate_bits, self.altitude_bits, self.half_steps
        )
        fractions = {"minor": precision.minor, "rise": precision.rise}
        lane_bits = exact_log2(lane_count)
        row_bits = lane_row_bits(lane_count, self.coordinate_bits)
        begins = self.launched.starts_segment

        m.d.sync += token.eq(self.launched)

        # In the last group, only the lanes up to the end of the segment have a cell.
        rest = Signal(max(1, lane_bits), reset_less=True)
        step = Signal.like(self.step, reset_less=True)
        steep, descending = Signal(reset_less=True), Signal(reset_less=True)
        major = Signal(self.coordinate_bits, reset_less=True)
        rest_now = segment.length[:lane_bits]
        with m.If(begins):
            m.d.sync += [
                rest.eq(rest_now),
                step.eq(self.step),
                steep.eq(segment.steep),
                descending.eq(segment.descending),
                major.eq(segment.major),
            ]
        with m.Else():
            m.d.sync += major.eq(Mux(descending, major - lane_count, major + lane_count))
        m.d.comb += [
            self.group.steep.eq(steep),
            self.group.descending.eq(descending),
            self.group.major.eq(major),
            self.group.cells.eq(Mux(token.ends_segment, rest + 1, lane_count)),
        ]

        # Both rows of the next group: the row of its first cell, and the row beyond it.
        begin = segment.major[lane_bits:]
        beyond = Signal(row_bits)
        next_row, next_beyond = (
            Signal(row_bits, name=name, reset_less=True) for name in ("next_row", "next_beyond")
        )
        at_first, then = Signal(signed(2)), Signal(signed(2))
        m.d.comb += [
            at_first.eq(Mux(segment.descending, -1, 1)),
            then.eq(Mux(descending, -1, 1)),
            beyond.eq(begin + at_first),
        ]
        # Sums first: `begins` drives all lanes, and comes late.
        m.d.sync += [
            next_row.eq(Mux(begins, beyond, next_row + then)),
            next_beyond.eq(Mux(begins, beyond + at_first, next_beyond + then)),
        ]

        first = segment.major[:lane_bits]
        for number, (lane, start) in enumerate(zip(self.lanes, self.origins, strict=True)):
            motion = Signal.like(step, name=f"motion_{number}", reset_less=True)
            row = Signal(row_bits, name=f"row_{number}", reset_less=True)
            in_last = Signal(name=f"in_last_{number}", reset_less=True)
            late = Signal(name=f"late_{number}", reset_less=True)
            is_late = Signal(name=f"is_late_{number}")
            # Written without comparisons whose result is constant.
            m.d.comb += is_late.eq(
                Mux(
                    segment.descending,
                    first < number if number else 0,
                    first > number if number < lane_count - 1 else 0,
                )
            )
            with m.If(begins):
                m.d.sync += [
                    motion.eq(start),
                    late.eq(is_late),
                    row.eq(Mux(is_late, beyond, begin)),
                    in_last.eq(segment.places[number] <= rest_now if lane_bits else 1),
                ]
            with m.Else():
                m.d.sync += [
                    *(motion[axis].eq(motion[axis] + step[axis]) for axis in fractions),
                    row.eq(Mux(late, next_beyond, next_row)),
                ]

            minor = motion.minor[precision.minor :]
            m.d.comb += [
                self.group.minors[number].eq(minor),
                lane.valid.eq(token.valid & (in_last | ~token.ends_segment)),
                lane.row.eq(row),
                lane.minor.eq(minor),
                lane.ceiling.eq(motion.rise[precision.rise :]),
            ]
        if self.half_steps:
            self._end_low(m, rest_now)

        return m

    def _end_low(self, m, rest):
        """Give the cell at the lower end of the segment the altitude of that end.

        That is the first cell or, if the segment falls, the last one, ``rest`` places after the
        first of its group.
        """
        segment, begins = self.segment, self.launched.starts_segment
        lowest = Signal(self.altitude_bits, reset_less=True)
        falling = segment.rise < 0
        with m.If(begins):
            m.d.sync += lowest.eq(segment.lowest)
        for number, (lane, place) in enumerate(zip(self.lanes, segment.places, strict=True)):
            is_first = Signal(name=f"is_first_{number}", reset_less=True)
            is_last = Signal(name=f"is_last_{number}", reset_less=True)
            m.d.sync += is_first.eq(begins & ~falling & (place == 0))
            with m.If(begins):
                m.d.sync += is_last.eq(falling & (place == rest))
            with m.If(is_first | is_last & self.token.ends_segment):
                m.d.comb += lane.ceiling.eq(lowest)
