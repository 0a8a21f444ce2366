"""Walks the columns that the coarse map has not cleared, in the detailed map."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from hdl.config import Config
from hdl.feasibility.delay import delayed
from hdl.feasibility.hierarchical_columns import column_layout
from hdl.feasibility.hierarchical_setup import group_cells
from hdl.feasibility.lanes import group_layout
from hdl.feasibility.reciprocal import Precision
from hdl.feasibility.terrain_memory import lane_layout


__all__ = ["CellWalker", "passage_layout", "task_layout"]


def task_layout(config: Config) -> data.StructLayout:
    """A column, and what is to be done about it.

    ``walk`` it; otherwise the coarse map has cleared it. ``skipped``: cells of its segment that
    were cleared between the task before and this column. ``first``: of its path.
    """
    return data.StructLayout(
        {
            "column": column_layout(config),
            "walk": 1,
            "skipped": config.segment_cells_bits,
            "first": 1,
        }
    )


def passage_layout(config: Config) -> data.StructLayout:
    """What a group, or a column that is cleared, means for its path.

    ``read``: its cells are looked at. ``skipped``: cells passed before it, see
    :func:`task_layout`, and ``cells``: its own. ``first`` of its path, ``segment`` in it;
    ``ends_segment``, ``ends_path``: the last of these.
    """
    return data.StructLayout(
        {
            "read": 1,
            "skipped": config.segment_cells_bits,
            "cells": range(config.coarse_factor + 1),
            "first": 1,
            "segment": config.segment_bits,
            "ends_segment": 1,
            "ends_path": 1,
        }
    )


class CellWalker(wiring.Component):
    """Walks a group of cells a clock: those of a column whose lanes follow each other.

    A group never goes past a multiple of :func:`hdl.feasibility.hierarchical_setup.group_cells`
    along the longer side, so that each lane of it has a fixed place there. A task takes a clock a
    group, or one if it is cleared, and is taken in the last clock of the one before.

    With several lanes the group comes two clocks after it is begun, for the sums of each lane: the
    place is made up of a multiple of four steps, and of the rest.

    Parameters
    ----------
    config : Config

    Members
    -------
    tasks : In(stream.Signature(task_layout))
    drop : In(1)
        Leave the path under way, that of the task taken last. What is begun in this clock is walked
        all the same, without its ``ends_path``.
    follow : In(1)
        With ``drop``: further tasks of that path follow, up to its last one. They are taken one a
        clock, and dropped.
    beginning : Out(1)
        A group, or a cleared column, is begun in this clock.
    begun : Out(passage_layout)
        Of that.
    valid : Out(1)
    passage : Out(passage_layout)
        The same, :attr:`lead` clocks later, with the cells to be tested:
    group : Out(group_layout)
    lanes : Out(lane_layout).array(lanes)

    Attributes
    ----------
    lead : int
        Clocks from ``begun`` to ``passage``.
    """

    def __init__(self, config):
        self.config = config
        self.lead = 0 if config.lanes == 1 else 2
        super().__init__(
            {
                "tasks": In(stream.Signature(task_layout(config))),
                "drop": In(1),
                "follow": In(1),
                "beginning": Out(1),
                "begun": Out(passage_layout(config)),
                "valid": Out(1),
                "passage": Out(passage_layout(config)),
                "group": Out(group_layout(config)),
                "lanes": Out(lane_layout(config)).array(config.lanes),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config, begun = self.config, self.begun
        bits = exact_log2(group_cells(config))

        active = Signal()
        dropping = Signal()
        task = Signal(task_layout(config), reset_less=True)
        column = task.column

        ahead = Signal(bits)
        ended = Signal()
        free = Signal()
        load = Signal()
        m.d.comb += [
            ahead.eq(Mux(column.back, column.major, ~column.major)),
            ended.eq(~task.walk | (column.more <= ahead)),
            self.beginning.eq(active),
            free.eq(~active | ended),
            self.tasks.ready.eq(dropping | (free & ~self.drop)),
            load.eq(self.tasks.valid & self.tasks.ready & ~dropping),
            begun.read.eq(task.walk),
            begun.skipped.eq(task.skipped),
            begun.cells.eq(Mux(ended, column.more, ahead) + 1),
            begun.first.eq(task.first),
            begun.segment.eq(column.segment),
            begun.ends_segment.eq(ended & column.ends_segment),
            begun.ends_path.eq(ended & column.ends_path & ~self.drop),
        ]

        with m.If(self.drop):
            m.d.sync += dropping.eq(self.follow & ~(active & column.ends_path))
        with m.Elif(dropping & self.tasks.valid & self.tasks.p.column.ends_path):
            m.d.sync += dropping.eq(0)

        with m.If(self.drop):
            m.d.sync += active.eq(0)
        with m.Elif(free):
            m.d.sync += active.eq(load)

        block = column.major >> bits
        with m.If(load):
            m.d.sync += task.eq(self.tasks.p)
        with m.Else():
            m.d.sync += [
                task.skipped.eq(0),
                task.first.eq(0),
                column.more.eq(column.more - ahead - 1),
                column.major.eq(
                    Cat(column.back.replicate(bits), Mux(column.back, block - 1, block + 1))
                ),
                column.minor_sum.eq(column.minor_sum + (column.minor_slope << bits)),
                column.altitude_sum.eq(column.altitude_sum + (column.altitude_slope << bits)),
            ]

        valid = self.beginning
        for clock in range(self.lead):
            earlier = Signal(name=f"valid_{clock}")
            m.d.sync += earlier.eq(valid)
            valid = earlier
        passage = delayed(m, begun, self.lead, "passage")
        major = delayed(m, column.major, self.lead, "major")
        back = delayed(m, column.back, self.lead, "back")
        minors = self._sums(m, "minor", column.minor_sum, column.minor_slope, column.back)
        ceilings = self._sums(
            m, "altitude", column.altitude_sum, column.altitude_slope, column.back
        )
        m.d.comb += [
            self.valid.eq(valid),
            self.passage.eq(passage),
            self.group.steep.eq(delayed(m, column.steep, self.lead, "steep")),
            self.group.descending.eq(back),
            self.group.major.eq(major),
            self.group.cells.eq(passage.cells),
        ]

        # Lanes from that of the first cell to that of the last.
        lane_bits = exact_log2(config.lanes)
        start = major[:lane_bits]
        for number, lane in enumerate(self.lanes):
            distance = Signal(lane_bits + 1, name=f"distance_{number}")
            m.d.comb += [
                distance.eq(Mux(back, start - number, number - start)),
                lane.valid.eq(valid & passage.read & (distance < passage.cells)),
                lane.row.eq(major >> lane_bits),
                lane.minor.eq(minors[number]),
                lane.ceiling.eq(ceilings[number]),
                self.group.minors[number].eq(minors[number]),
            ]

        return m

    def _sums(self, m, name, first, slope, back):
        """Return the whole part of a sum for each lane, from that of the first place of its group.

        The place of a lane is its number modulo that of places, counted from the other end where
        the segment goes back.
        """
        config = self.config
        fraction = Precision.of(config).reciprocal
        places = group_cells(config)
        if config.lanes == 1:
            return [first >> fraction]

        highs, lows = [], []
        for quarter in range((places + 3) // 4):
            high = Signal(len(first), name=f"{name}_high_{quarter}", reset_less=True)
            step = slope << 2
            m.d.sync += high.eq(
                first + sum((step << bit for bit in range(2) if quarter >> bit & 1), C(0))
            )
            highs.append(high)
        for rest in range(min(places, 4)):
            low = Signal(len(first), name=f"{name}_low_{rest}", reset_less=True)
            m.d.sync += low.eq(sum((slope << bit for bit in range(2) if rest >> bit & 1), C(0)))
            lows.append(low)
        turned = delayed(m, back, 1, f"{name}_turned")

        sums = []
        for number in range(config.lanes):
            place = number % places
            mirrored = places - 1 - place
            total = Signal(len(first), name=f"{name}_sum_{number}", reset_less=True)
            m.d.sync += total.eq(
                Mux(turned, highs[mirrored // 4], highs[place // 4])
                + Mux(turned, lows[mirrored % 4], lows[place % 4])
            )
            sums.append(total >> fraction)
        return sums
