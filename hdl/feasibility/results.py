"""From the steps of a walker to verdicts and counts."""

from amaranth import *
from amaranth.lib import data, fifo, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from hdl.config import Config
from hdl.feasibility.layouts import CYCLES_BITS, count_layout, verdict_layout
from hdl.feasibility.sizes import VERDICT_PLACES, count_places
from hdl.feasibility.walker import step_layout


__all__ = ["Results"]


class Results(wiring.Component):
    """Sums up the steps of each path, and queues what comes of them.

    A path is decided by its first step that hits or, when counting, by its last step. Its verdict
    is offered in the next clock, if all before it have been transferred. When it is offered, all
    its counts have been offered or are next in their queue. A place in either queue is kept before
    the path or segment begins, so that steps need not wait. Without a genetic core, paths come
    alone, there is one place for a verdict and one for a count, and ``counts`` must always be
    ready.

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

        verdict = Signal(self.verdicts.payload.shape())
        m.d.comb += [
            verdict.collision.eq(step.hit | earlier),
            verdict.cells.eq(cells),
            verdict.reads.eq(step.reads),
            verdict.cycles.eq(clocks + 1),
            verdict.entries.eq(Mux(step.first, 0, entries) + entered),
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
        verdict_depth = VERDICT_PLACES if config.genetic else 1
        _queue(m, "verdict_queue", verdict_depth, decides, verdict, flipped(self.verdicts))

        # Counts of the segment so far.
        fresh, collided = Signal(init=1), Signal()
        collides = Signal()
        terrain, nofly = (Signal(config.segment_cells_bits, name=n) for n in ("terrain", "nofly"))
        depth = count_places(config) if config.genetic else 1
        entry = Signal(self.counts.payload.shape())
        m.d.comb += [
            entry.segment.eq(step.segment),
            entry.terrain.eq(Mux(fresh | step.first, 0, terrain) + step.terrain),
            entry.nofly.eq(Mux(fresh | step.first, 0, nofly) + step.nofly),
            entered.eq(live & self.count & step.ends_segment & (collides | step.hit)),
            collides.eq(collided & ~fresh & ~step.first),
        ]
        with m.If(live):
            m.d.sync += [
                fresh.eq(step.ends_segment),
                collided.eq(collides | step.hit),
                terrain.eq(entry.terrain),
                nofly.eq(entry.nofly),
                entries.eq(verdict.entries),
            ]
        _queue(m, "count_queue", depth, entered, entry, flipped(self.counts))

        # Places not yet promised. Whether there are any comes out of a register: much hangs on it.
        places = Signal(range(verdict_depth + 1), init=verdict_depth)
        transferred = self.verdicts.valid & self.verdicts.ready
        m.d.sync += [
            places.eq(places + transferred - self.begins),
            self.room.eq(transferred | (places != self.begins)),
        ]

        if config.genetic:
            self._promise_counts(m, depth, live & self.count & step.ends_segment & ~entered)

        return m

    def _promise_counts(self, m, depth, unused):
        """Keep a place for the count of each segment that begins."""
        segment_places = Signal(range(depth + 1), init=depth)
        freed, used = Signal(), Signal()
        m.d.comb += [
            freed.eq(self.counts.valid & self.counts.ready),
            used.eq(self.segment_begins & self.count),
        ]
        m.d.sync += [
            segment_places.eq(segment_places + unused + freed - used),
            self.segment_room.eq(~self.count | unused | freed | (segment_places != used)),
        ]


def _queue(m, name, depth, put, word, words):
    """Let ``words`` out in order, each put in when there is a place; one place is a register."""
    if depth > 1:
        queue = fifo.SyncFIFO(width=len(Value.cast(word)), depth=depth)
        m.submodules[name] = queue
        m.d.comb += [queue.w_data.eq(word), queue.w_en.eq(put)]
        connect(m, queue.r_stream, words)
    else:
        with m.If(words.ready):
            m.d.sync += words.valid.eq(0)
        with m.If(put):
            m.d.sync += [words.valid.eq(1), words.payload.eq(word)]
