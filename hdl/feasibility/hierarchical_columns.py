"""Walks segments column by column: the cells of a segment beside the same coarse blocks."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config
from hdl.feasibility.hierarchical_setup import span_layout
from hdl.feasibility.reciprocal import Precision


__all__ = ["ColumnWalker", "column_layout", "probe_layout"]


def column_layout(config: Config) -> data.StructLayout:
    """Cells of a segment, in a row along its longer side, that lie within a row of coarse blocks.

    ``steep``, ``back``, slopes: of the segment, see
    :func:`hdl.feasibility.hierarchical_setup.span_layout`. ``major`` of the first cell, ``more``
    cells after it. ``minor_sum``, ``altitude_sum``: at the cell with which the first cell's group
    begins. ``segment`` in its path; ``ends_segment``, ``ends_path``: nothing of these comes after.
    """
    fraction = Precision.of(config).reciprocal
    span = span_layout(config)
    return data.StructLayout(
        {
            "steep": 1,
            "back": 1,
            "major": config.coordinate_bits,
            "more": config.coordinate_bits - config.coarse_bits,
            "minor_sum": config.coordinate_bits + fraction,
            "altitude_sum": config.altitude_bits + fraction,
            "minor_slope": span["minor_slope"].shape,
            "altitude_slope": span["altitude_slope"].shape,
            "segment": config.segment_bits,
            "ends_segment": 1,
            "ends_path": 1,
        }
    )


def probe_layout(config: Config) -> data.StructLayout:
    """What the coarse map is asked about a column: whether ground is at ``lowest`` or above.

    Its blocks are ``row`` along the longer side of the segment, and from ``first`` to ``last``
    along the other, which are the same or neighbours.
    """
    return data.StructLayout(
        {
            "row": config.coarse_bits,
            "first": config.coarse_bits,
            "last": config.coarse_bits,
            "lowest": config.altitude_bits,
        }
    )


class ColumnWalker(wiring.Component):
    """Offers a column a clock, with a test that is safe: what passes it collides nowhere.

    A column is never longer than a block is wide, and a segment climbs along its shorter side by at
    most a cell a step: so the cells between the first and the last of a column are in the block of
    one of these two. And the lowest altitude of a column is at one of its ends. Both are exact, for
    the cells of the detailed map themselves.

    The first column of a segment comes a clock after the segment is taken, which is in the clock of
    the last one of the segment before.

    Parameters
    ----------
    config : Config

    Members
    -------
    spans : In(stream.Signature(span_layout))
    room, segment_room : In(1)
        The first segment of a path, and any segment, may be taken.
    begins, segment_begins : Out(1)
        They are, and not only to be dropped.
    allow : In(1)
        A column may be offered.
    drop : In(1)
        Leave the path under way: that whose column was offered last, which must not have been its
        last one. A column may be offered in this clock, too; it counts for nothing. Later segments
        of that path are taken one a clock, and dropped.
    valid : Out(1)
        There is a column in this clock.
    column : Out(column_layout)
    probe : Out(probe_layout)
    """

    def __init__(self, config):
        self.config = config
        super().__init__(
            {
                "spans": In(stream.Signature(span_layout(config))),
                "room": In(1),
                "segment_room": In(1),
                "begins": Out(1),
                "segment_begins": Out(1),
                "allow": In(1),
                "drop": In(1),
                "valid": Out(1),
                "column": Out(column_layout(config)),
                "probe": Out(probe_layout(config)),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config
        fraction = Precision.of(config).reciprocal
        bits = config.coordinate_bits - config.coarse_bits

        offered, column, probe = self.spans.p, self.column, self.probe
        active = Signal()
        dropping = Signal()
        span = Signal(span_layout(config), reset_less=True)
        # Of the column under way: its first cell, and the segment's steps from there.
        left = Signal.like(span.steps, reset_less=True)
        minor = Signal.like(span.minor, reset_less=True)
        altitude = Signal.like(span.altitude, reset_less=True)

        ahead = Signal(bits)
        ended = Signal()
        opens = Signal()
        free = Signal()
        load = Signal()
        m.d.comb += [
            ahead.eq(Mux(span.back, span.major, ~span.major)),
            ended.eq(left <= ahead),
            opens.eq(offered.number == 0),
            self.valid.eq(active & self.allow),
            free.eq(~active | (self.valid & ended)),
            self.spans.ready.eq(
                dropping | (free & ~self.drop & self.segment_room & (self.room | ~opens))
            ),
            load.eq(self.spans.valid & self.spans.ready & ~dropping),
            self.begins.eq(load & opens),
            self.segment_begins.eq(load),
        ]

        minor_last = Signal.like(minor)
        altitude_last = Signal.like(altitude)
        m.d.comb += [
            minor_last.eq(Mux(ended, span.minor_goal, span.minor_far >> fraction)),
            altitude_last.eq(Mux(ended, span.altitude_goal, span.altitude_far >> fraction)),
            probe.row.eq(span.major >> bits),
            probe.first.eq(minor >> bits),
            probe.last.eq(minor_last >> bits),
            probe.lowest.eq(Mux(span.falls, altitude_last, altitude)),
            column.steep.eq(span.steep),
            column.back.eq(span.back),
            column.major.eq(span.major),
            column.more.eq(Mux(ended, left, ahead)),
            column.minor_sum.eq(span.minor_near),
            column.altitude_sum.eq(span.altitude_near),
            column.minor_slope.eq(span.minor_slope),
            column.altitude_slope.eq(span.altitude_slope),
            column.segment.eq(span.number),
            column.ends_segment.eq(ended),
            column.ends_path.eq(ended & span.last),
        ]

        with m.If(self.drop):
            m.d.sync += dropping.eq(~(active & span.last))
        with m.Elif(dropping & self.spans.valid & offered.last):
            m.d.sync += dropping.eq(0)

        with m.If(self.drop):
            m.d.sync += active.eq(0)
        with m.Elif(free):
            m.d.sync += active.eq(load)

        next_minor = Signal.like(span.minor_far)
        next_altitude = Signal.like(span.altitude_far)
        row = span.major >> bits
        m.d.comb += [
            next_minor.eq(span.minor_far + span.minor_slope),
            next_altitude.eq(span.altitude_far + span.altitude_slope),
        ]
        with m.If(load):
            m.d.sync += [
                span.eq(offered),
                left.eq(offered.steps),
                minor.eq(offered.minor),
                altitude.eq(offered.altitude),
            ]
        with m.Elif(self.valid):
            m.d.sync += [
                left.eq(left - ahead - 1),
                span.major.eq(Cat(span.back.replicate(bits), Mux(span.back, row - 1, row + 1))),
                span.minor_near.eq(next_minor),
                span.altitude_near.eq(next_altitude),
                span.minor_far.eq(span.minor_far + (span.minor_slope << bits)),
                span.altitude_far.eq(span.altitude_far + (span.altitude_slope << bits)),
                minor.eq(next_minor >> fraction),
                altitude.eq(next_altitude >> fraction),
            ]

        return m
