"""From the steps of a walker to verdicts and counts."""

from amaranth import *
from amaranth.lib import data, fifo, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import ceil_log2

from hdl.config import Config
from hdl.feasibility.layouts import CYCLES_BITS, count_layout, verdict_layout
from hdl.feasibility.walker import step_layout


__all__ = ["COUNTS", "VERDICTS", "Results"]

#: Verdicts and counts that can wait to be transferred: as many as paths and segments, of a cell
#: each, can be under way in a walker, so that those follow each other at full rate. Of counts there
#: is room for one of each segment of a path.
VERDICTS = 8
COUNTS = 16


class Results(wiring.Component):
    """Sums up the steps of each path, and queues what comes of them.

    A path is decided by its first step that hits or, when counting, by its last step. Its verdict
    is offered in the next clock, if all before it have been transferred. When it is offered, all
    its counts have been offered or are next in their queue. A place in either queue is kept before
    the path or segment begins, so that steps need not wait.

    ``cycles`` of a verdict are clocks from that in which the first point of the path is taken to
    that in which its verdict is offered if nothing before it waits to be transferred; but not
    before the clock after that of the previous path. So they sum up to all clocks with a path.

    Parameters
    ----------
    config : Config

    Members
    -------
    count : In(1)
        As of the walker.
    taken : In(1)
        The first point of a path is taken.
    begins, segment_begins : In(1)
    room, segment_room : Out(1)
    step : In(step_layout)
    drop : Out(1)
        See :func:`hdl.feasibility.walker.walker_signature`. ``drop`` follows ``step`` within the
        clock.
    hit, free : Out(1)
        The first hit of a path, and the end of a path that is free: in the clock of the step.
    verdicts : Out(stream.Signature(verdict_layout))
    counts : Out(stream.Signature(count_layout))
    """

    def __init__(self, config):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")

        self.config = config
        super().__init__(
            {
                "count": In(1),
                "taken": In(1),
                "begins": In(1),
                "segment_begins": In(1),
                "room": Out(1, init=1),
                "segment_room": Out(1, init=1),
                "step": In(step_layout(config)),
                "drop": Out(1),
                "hit": Out(1),
                "free": Out(1),
                "verdicts": Out(stream.Signature(verdict_layout(config))),
                "counts": Out(stream.Signature(count_layout(config))),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config, step = self.config, self.step

        # Of a path that has been decided, steps may still come.
        decided = Signal(init=1)
        live = Signal()
        decides = Signal()
        m.d.comb += live.eq(step.valid & (step.first | ~decided))
        with m.If(live):
            m.d.sync += decided.eq(decides)

        # The first hit, from the clock after it on: needed where the path is walked to its end.
        found = Signal(
            data.StructLayout(
                {
                    "segment": config.segment_bits,
                    "x": config.coordinate_bits,
                    "y": config.coordinate_bits,
                    "coarse": 1,
                    "cells": config.path_cells_bits,
                }
            )
        )
        has_hit, earlier = Signal(), Signal()
        passed, cells = Signal(config.path_cells_bits), Signal(config.path_cells_bits)
        m.d.comb += [
            earlier.eq(has_hit & ~step.first),
            self.hit.eq(live & step.hit & ~earlier),
            # Unless counting, no hit was earlier where the path has not been decided.
            self.drop.eq(live & step.hit & ~self.count),
            decides.eq(live & (step.ends_path | (step.hit & ~self.count))),
            self.free.eq(decides & ~step.hit & ~earlier),
            cells.eq(
                Mux(step.first, 0, passed) + Mux(step.hit & ~earlier, step.before + 1, step.cells)
            ),
        ]
        with m.If(live):
            m.d.sync += [
                passed.eq(Mux(step.first, 0, passed) + step.cells),
                has_hit.eq(step.hit | earlier),
            ]
        with m.If(self.hit):
            m.d.sync += [
                found.segment.eq(step.segment),
                found.x.eq(step.x),
                found.y.eq(step.y),
                found.coarse.eq(step.coarse),
                found.cells.eq(cells),
            ]

        # Clocks since the previous verdict was offered or, if that is later, since the first point
        # was taken; less the present one. A step decides one clock before its verdict is offered.
        clocks = Signal(CYCLES_BITS, init=1)
        undecided = Signal(range(64))
        m.d.sync += undecided.eq(undecided + self.taken - decides)
        with m.If(decides):
            m.d.sync += clocks.eq(0)
        with m.Elif(undecided.any() | self.taken | ~clocks.any()):
            m.d.sync += clocks.eq(clocks + 1)

        entries = Signal(config.segment_bits + 1)
        entered = Signal()

        m.submodules.verdict_queue = verdict_queue = fifo.SyncFIFO(
            width=self.verdicts.payload.shape().size, depth=VERDICTS
        )
        verdict = Signal(self.verdicts.payload.shape())
        m.d.comb += [
            verdict.collision.eq(step.hit | earlier),
            verdict.cells.eq(cells),
            verdict.reads.eq(step.reads),
            verdict.cycles.eq(clocks + 1),
            verdict.entries.eq(Mux(step.first, 0, entries) + entered),
            verdict_queue.w_data.eq(verdict),
            verdict_queue.w_en.eq(decides),
        ]
        with m.If(earlier):
            m.d.comb += [
                verdict.segment.eq(found.segment),
                verdict.x.eq(found.x),
                verdict.y.eq(found.y),
                verdict.coarse.eq(found.coarse),
                verdict.cells.eq(found.cells),
            ]
        with m.Elif(step.hit):
            m.d.comb += [
                verdict.segment.eq(step.segment),
                verdict.x.eq(step.x),
                verdict.y.eq(step.y),
                verdict.coarse.eq(step.coarse),
            ]
        connect(m, verdict_queue.r_stream, flipped(self.verdicts))

        # Counts of the segment so far.
        fresh, collided = Signal(init=1), Signal()
        collides, step_collides = Signal(), Signal()
        terrain, nofly = (Signal(config.segment_cells_bits, name=n) for n in ("terrain", "nofly"))
        depth = max(COUNTS, 1 << ceil_log2(config.max_segments))
        m.submodules.count_queue = count_queue = fifo.SyncFIFO(
            width=self.counts.payload.shape().size, depth=depth
        )
        entry = Signal(self.counts.payload.shape())
        m.d.comb += [
            entry.segment.eq(step.segment),
            entry.terrain.eq(Mux(fresh | step.first, 0, terrain) + step.terrain),
            entry.nofly.eq(Mux(fresh | step.first, 0, nofly) + step.nofly),
            entered.eq(live & self.count & step.ends_segment & (collides | step_collides)),
            step_collides.eq(step.terrain.any() | step.nofly.any()),
            collides.eq(collided & ~fresh & ~step.first),
            count_queue.w_data.eq(entry),
            count_queue.w_en.eq(entered),
        ]
        with m.If(live):
            m.d.sync += [
                fresh.eq(step.ends_segment),
                collided.eq(collides | step_collides),
                terrain.eq(entry.terrain),
                nofly.eq(entry.nofly),
                entries.eq(verdict.entries),
            ]
        connect(m, count_queue.r_stream, flipped(self.counts))

        # Places not yet promised. Whether there are any comes out of a register: much hangs on it.
        places = Signal(range(VERDICTS + 1), init=VERDICTS)
        transferred = self.verdicts.valid & self.verdicts.ready
        m.d.sync += [
            places.eq(places + transferred - self.begins),
            self.room.eq(transferred | (places != self.begins)),
        ]

        segment_places = Signal(range(depth + 1), init=depth)
        unused, freed, used = Signal(), Signal(), Signal()
        m.d.comb += [
            unused.eq(live & self.count & step.ends_segment & ~entered),
            freed.eq(self.counts.valid & self.counts.ready),
            used.eq(self.segment_begins & self.count),
        ]
        m.d.sync += [
            segment_places.eq(segment_places + unused + freed - used),
            self.segment_room.eq(~self.count | unused | freed | (segment_places != used)),
        ]

        return m
