"""Collector of results: turns the steps of a walker into verdicts and counts."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.feasibility.layouts import CYCLES_BITS, count_layout, step_layout, verdict_layout
from pathgene.hdl.primitives.buffers import ResultQueue
from pathgene.hdl.primitives.unit import Count, Unit, Width


__all__ = ["VERDICT_PLACES", "ResultCollector"]

#: Number of verdicts that can wait, including paths in flight: one for each one-cell path that can
#: be in flight in a walker, so that such paths follow each other at full rate.
VERDICT_PLACES = 8


class ResultCollector(Unit):
    """Sums up the steps of each path, and queues verdicts and counts.

    A path is decided by its first step that hits or, when counting, by its last step. Its verdict
    is offered in the next cycle if all earlier verdicts have been transferred. By then, all its
    counts have been offered or are next in their queue. A place in either queue is reserved before
    the path or segment begins, so that steps need not wait. With one place for a count, none is
    reserved, and ``counts`` must always be ready.

    The ``cycles`` of a verdict begin with the cycle in which the path's first point is taken or, if
    later, with the cycle after the previous path's last. They end with the cycle in which the
    verdict is offered, assuming no earlier verdict waits. The sum over all verdicts is therefore
    the number of cycles with a path in flight.

    Members
    -------
    count : In(1)
        Count colliding cells.
    taken : In(1)
        The first point of a path is taken.
    begins, segment_begins : In(1)
    room, segment_room : Out(1)
    step : In(step_layout)
    drop : Out(1)
        See :func:`pathgene.hdl.feasibility.layouts.walker_signature`. ``drop`` follows
        ``step`` within the cycle.
    hit, free : Out(1)
        First hit of a path, or its end without a hit, in the cycle of the step.
    verdicts : Out(stream.Signature(verdict_layout))
    counts : Out(stream.Signature(count_layout))
    """

    coordinate_bits: Width(1)
    segment_bits: Width(1, text="Number of a segment in its path.")
    path_cells_bits: Width(1, text="Cells of a path.", name="Width of a path's cells")
    verdict_places: Count(1, text="Verdicts that can wait.", name="Places for verdicts")
    count_places: Count(1, text="Counts that can wait.", name="Places for counts")

    def interface(self):
        sizes = (self.coordinate_bits, self.segment_bits, self.path_cells_bits)
        return {
            "count": In(1),
            "taken": In(1),
            "begins": In(1),
            "segment_begins": In(1),
            "room": Out(1, init=1),
            "segment_room": Out(1, init=1),
            "step": In(step_layout(*sizes)),
            "drop": Out(1),
            "hit": Out(1),
            "free": Out(1),
            "verdicts": Out(stream.Signature(verdict_layout(*sizes))),
            "counts": Out(stream.Signature(count_layout(self.coordinate_bits, self.segment_bits))),
        }

    def elaborate(self, platform):
        m = Module()
        step = self.step

        # Steps of a path may still come after it has been decided.
        decided = Signal(init=1)
        live = Signal()
        decides = Signal()
        m.d.comb += live.eq(step.valid & (step.first | ~decided))
        with m.If(live):
            m.d.sync += decided.eq(decides)

        # The first hit of paths that are walked to their end.
        found = Signal(
            data.StructLayout(
                {
                    "segment": self.segment_bits,
                    "x": self.coordinate_bits,
                    "y": self.coordinate_bits,
                    "coarse": 1,
                    "cells": self.path_cells_bits,
                }
            )
        )
        has_hit, earlier = Signal(), Signal()
        passed, cells = Signal(self.path_cells_bits), Signal(self.path_cells_bits)
        m.d.comb += [
            earlier.eq(has_hit & ~step.first),
            self.hit.eq(live & step.hit & ~earlier),
            # Unless counting, an undecided path has no earlier hit.
            self.drop.eq(live & step.hit & ~self.count),
            decides.eq(live & (step.ends_path | (step.hit & ~self.count))),
            self.free.eq(decides & ~step.hit & ~earlier),
            cells.eq(
                # Not used if there was an earlier hit.
                Mux(step.first, 0, passed) + Mux(step.hit, step.until, step.cells)
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

        # Cycles since the previous verdict was offered or, if that is later, since the first point
        # was taken. A step decides one cycle before its verdict is offered. Events are counted one
        # cycle later, because their signals arrive late in their cycle.
        cycles, cycles_before = Signal(CYCLES_BITS), Signal(CYCLES_BITS, init=2)
        was_taken, was_decided, counts = Signal(), Signal(), Signal()
        undecided = Signal(range(64))
        m.d.sync += [
            was_taken.eq(self.taken),
            was_decided.eq(decides),
            undecided.eq(undecided + was_taken - was_decided),
            counts.eq(undecided.any() | was_taken | was_decided),
            cycles_before.eq(cycles),
        ]
        m.d.comb += cycles.eq(Mux(was_decided, 1, cycles_before + (counts | was_taken)))

        entries = Signal(self.segment_bits + 1)
        entered = Signal()

        verdict = Signal(self.verdicts.payload.shape())
        m.d.comb += [
            verdict.collision.eq(step.hit | earlier),
            verdict.cells.eq(cells),
            verdict.reads.eq(step.reads),
            verdict.cycles.eq(cycles),
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
        verdict_queue = ResultQueue(verdict.shape(), self.verdict_places)
        m.submodules.verdict_queue = verdict_queue
        m.d.comb += [verdict_queue.put.eq(decides), verdict_queue.word.eq(verdict)]
        connect(m, verdict_queue.words, flipped(self.verdicts))

        # Counts of the current segment.
        fresh, collided = Signal(init=1), Signal()
        collides = Signal()
        terrain, nofly = (Signal.like(step[name], name=name) for name in ("terrain", "nofly"))
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
        m.submodules.count_queue = count_queue = ResultQueue(entry.shape(), self.count_places)
        m.d.comb += [count_queue.put.eq(entered), count_queue.word.eq(entry)]
        connect(m, count_queue.words, flipped(self.counts))

        freed = self.verdicts.valid & self.verdicts.ready
        m.d.sync += self.room.eq(_promised(m, "places", self.verdict_places, self.begins, freed))

        if self.count_places > 1:
            # Each new segment may need a count.
            freed = self.counts.valid & self.counts.ready
            unused = live & self.count & step.ends_segment & ~entered
            used = self.segment_begins & self.count
            more = _promised(m, "segment_places", self.count_places, used, freed, unused)
            m.d.sync += self.segment_room.eq(~self.count | more)

        return m


def _promised(m, name, depth, used, *freed):
    """Manage ``depth`` places; in a cycle, one may be used and several freed.

    Return a flag that a place is left in the next cycle. ``used`` and ``freed`` arrive late in
    their cycle, so places are counted in the next cycle.
    """
    places = Signal(range(depth + 1), init=depth, name=name)
    was_used = Signal(name=f"{name}_used")
    were_freed = [Signal(name=f"{name}_freed_{number}") for number in range(len(freed))]
    now = Signal(range(depth + 1), name=f"{name}_now")
    m.d.comb += now.eq(places + sum(were_freed) - was_used)
    m.d.sync += [
        places.eq(now),
        was_used.eq(used),
        *(was.eq(flag) for was, flag in zip(were_freed, freed, strict=True)),
    ]
    return Cat(freed).any() | Mux(used, now[1:].any(), now.any())
