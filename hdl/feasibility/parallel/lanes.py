"""Lanes, which walk a group of neighbouring cells of a segment each cycle."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from hdl.config import Config
from hdl.feasibility.parallel.reciprocal import Precision
from hdl.feasibility.parallel.segment_setup import segment_layout, token_layout
from hdl.feasibility.parallel.slopes import motion_layout
from hdl.feasibility.parallel.terrain_memory import lane_layout, lane_row_bits


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


class Lanes(wiring.Component):
    """Walks segments, ``lanes`` cells of one each cycle.

    Lane c has the cells whose major coordinate is c mod ``lanes``. Its cell in the first group
    depends on the start of the segment, so that each group but the last is full: a segment of n
    cells takes n / ``lanes`` cycles, rounded up. The rest is sums: all lanes gain the same in a
    cycle, see :class:`hdl.feasibility.parallel.reciprocal.Precision`.

    ``group`` and ``lanes`` follow their token in ``launched`` by a cycle.

    Source: *allaire two-tier*, section 5.3. Differs: its reference has several walkers, each with a
    part of the segment.

    Parameters
    ----------
    config : Config

    Members
    -------
    launched : In(token_layout)
    segment : In(segment_layout)
    origins : In(motion_layout).array(lanes)
    step : In(motion_layout)
        First cells and gain of the segment that ``launched`` starts.
    token : Out(token_layout)
        ``launched``, a cycle later.
    group : Out(group_layout)
    lanes : Out(lane_layout).array(lanes)
    """

    def __init__(self, config: Config):
        self.config = config
        super().__init__(
            {
                "launched": In(token_layout(config)),
                "segment": In(segment_layout(config)),
                "origins": In(motion_layout(config)).array(config.lanes),
                "step": In(motion_layout(config)),
                "token": Out(token_layout(config)),
                "group": Out(group_layout(config.lanes, config.coordinate_bits)),
                "lanes": Out(lane_layout(config)).array(config.lanes),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config, segment, token = self.config, self.segment, self.token
        precision = Precision.of(config)
        fractions = {"minor": precision.minor, "rise": precision.rise}
        lane_bits = exact_log2(config.lanes)
        row_bits = lane_row_bits(config.lanes, config.coordinate_bits)
        begins = self.launched.starts_segment

        m.d.sync += token.eq(self.launched)

        # In the last group, only the lanes up to the end of the segment have a cell.
        rest = Signal(max(1, lane_bits), reset_less=True)
        step = Signal(motion_layout(config), reset_less=True)
        steep, descending = Signal(reset_less=True), Signal(reset_less=True)
        major = Signal(config.coordinate_bits, reset_less=True)
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
            m.d.sync += major.eq(Mux(descending, major - config.lanes, major + config.lanes))
        m.d.comb += [
            self.group.steep.eq(steep),
            self.group.descending.eq(descending),
            self.group.major.eq(major),
            self.group.cells.eq(Mux(token.ends_segment, rest + 1, config.lanes)),
        ]

        # A group lies in two rows: that of its first cell, and the one beyond. Both of the next
        # group.
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
            motion = Signal(motion_layout(config), name=f"motion_{number}", reset_less=True)
            row = Signal(row_bits, name=f"row_{number}", reset_less=True)
            in_last = Signal(name=f"in_last_{number}", reset_less=True)
            late = Signal(name=f"late_{number}", reset_less=True)
            is_late = Signal(name=f"is_late_{number}")
            # Written so that no number is compared with what it always is.
            m.d.comb += is_late.eq(
                Mux(
                    segment.descending,
                    first < number if number else 0,
                    first > number if number < config.lanes - 1 else 0,
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

        return m
