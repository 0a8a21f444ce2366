"""Memo of segments: hits and margins of previously walked segments, by their ends.

The table has two halves. Tags, which are the ends of the segments, are read before the walker;
values, which are hits and margins, after it. A row immediately takes the tag of every segment that
is looked up in it: an answered segment finds its own tag, and any other segment is about to be
walked. Segments pass the walker in order, and values are read and written in that order. Therefore
a row has the value of a segment by the time a later segment with the same tag reads it, and still
has it even if another segment has taken the row meanwhile. The answer to a look-up only depends on
the previous segments, not on the cycles that they take.
"""

import itertools
from functools import reduce
from operator import xor

from amaranth import *
from amaranth.lib import data, memory, stream
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.planner.walker.layouts import (
    MARKS,
    corner_layout,
    identity_layout,
    segment_request_layout,
    walked_layout,
)
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.storage import BlockMemory
from pathgene.hdl.primitives.unit import PowerOfTwo, Unit, Width


__all__ = ["Memo", "row_bits_of"]


def row_bits_of(rows: int) -> int:
    """Return the width of a row number; 1 if there are no rows."""
    return max(1, exact_log2(rows)) if rows else 1


class Memo(Unit):
    """Direct-mapped table of segments with full tags: it never answers for a different segment.

    A segment is looked up per cycle, and is ``found`` 3 cycles after it is taken. If it is
    ``answered``, its stored hits and margin replace the values that return as ``walked``; otherwise
    those values are stored. ``results`` follow ``walked`` by 2 cycles. All ``found`` segments
    return, in order.

    Rows of earlier epochs are void. ``clear`` begins a new epoch; when the epoch numbers are used
    up, and after a reset, all rows are cleared, one per cycle.

    On a target the table is in block RAMs: with 512 rows and 60 bits of ends, two for tags and one
    for values.

    Attributes
    ----------
    row_bits : int

    Members
    -------
    clear : In(1)
        Forget all segments looked up before. Only while no segment is being looked up or walked,
        and not while ``busy``.
    busy : Out(1)
        Rows are being cleared, and no segment is taken.
    segments : In(stream.Signature(segment_request_layout))
        Segment with its marks.
    found : Out(stream.Signature(segment_request_layout))
        The same segments with their identities.
    walked : In(walked_layout)
    results : Out(walked_layout)
        Results with their marks.
    """

    rows: PowerOfTwo(
        2, 1 << 16, "Segments. With 0, no segment is answered; the cycles are the same.", also=(0,)
    )
    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    epoch_bits: Width(1, text="With 1, each ``clear`` makes all rows void.") = 8

    def interface(self):
        self.row_bits = row_bits_of(self.rows)
        corner = corner_layout(self.coordinate_bits, self.altitude_bits)
        ends = data.StructLayout({"start": corner, "stop": corner})
        self.stage_layout = data.StructLayout({"ends": ends, "marks": MARKS, "row": self.row_bits})
        self.tag_layout = data.StructLayout({"ends": ends, "epoch": self.epoch_bits})
        sizes, identity = (self.coordinate_bits, self.altitude_bits), identity_layout(self.row_bits)
        return {
            "clear": In(1),
            "busy": Out(1),
            "segments": In(stream.Signature(segment_request_layout(*sizes, MARKS))),
            "found": Out(stream.Signature(segment_request_layout(*sizes, identity))),
            "walked": In(walked_layout(*sizes, identity)),
            "results": Out(walked_layout(*sizes, MARKS)),
        }

    def elaborate(self, platform):
        m = Module()
        request, found = self.segments.p, self.found.p

        # Three stages: computation of the row number, read of the tag, tag in registers. Each takes
        # the next segment as soon as it is free.
        full = Signal(3)
        moves = Signal(3)
        m.d.comb += [
            moves[2].eq(~full[2] | self.found.ready),
            moves[1].eq(~full[1] | moves[2]),
            moves[0].eq(~full[0] | moves[1]),
            self.segments.ready.eq(moves[0] & ~self.busy),
            self.found.valid.eq(full[2]),
        ]
        taken = Signal(self.stage_layout)
        m.d.comb += [
            taken.ends.start.eq(request.start),
            taken.ends.stop.eq(request.stop),
            taken.marks.eq(request.identity),
            taken.row.eq(self._row_of(request.start, request.stop)),
        ]
        stages = [
            taken,
            *(Signal(self.stage_layout, name=f"stage_{n}", reset_less=True) for n in range(3)),
        ]
        comes = Cat(self.segments.valid & ~self.busy, full)
        for number, (at, following) in enumerate(itertools.pairwise(stages)):
            with m.If(moves[number]):
                m.d.sync += [full[number].eq(comes[number]), following.eq(at)]

        last = stages[-1]
        m.d.comb += [
            found.start.eq(last.ends.start),
            found.stop.eq(last.ends.stop),
            found.identity.marks.eq(last.marks),
            found.identity.row.eq(last.row),
        ]
        if self.rows:
            self._look_up(m, stages[1:], full, moves)
        self._exchange_values(m)

        return m

    def _row_of(self, start, stop):
        """Return the row of a segment: its ends, one of them shifted, folded by exclusive or."""
        mixed = start.as_value() ^ (stop.as_value() << 3)
        return Cat(reduce(xor, mixed[bit :: self.row_bits]) for bit in range(self.row_bits))

    def _look_up(self, m, stages, full, moves):
        """Compare the tags of the rows, and replace them with the tags of the segments."""
        asked, taken, last = stages
        present = Signal(self.epoch_bits)
        void = (1 << self.epoch_bits) - 1
        m.submodules.tags = tags = memory.Memory(
            shape=self.tag_layout, depth=self.rows, init=[], attrs={"no_rw_check": 1}
        )
        write, read = tags.write_port(), tags.read_port()

        # A tag is written in the cycle after it is read, which is too late for a segment in the
        # same row that follows immediately.
        fresh = Signal()
        repeats, same = (Signal(2, name=name) for name in ("repeats", "same"))
        known = Signal(self.tag_layout, reset_less=True)
        m.d.sync += fresh.eq(moves[1] & full[0])
        m.d.comb += [read.addr.eq(asked.row), read.en.eq(moves[1])]
        with m.If(moves[1]):
            m.d.sync += [
                repeats[0].eq(fresh & (asked.row == taken.row)),
                same[0].eq(_bits(asked.ends) == _bits(taken.ends)),
            ]
        with m.If(moves[2]):
            m.d.sync += [known.eq(read.data), repeats[1].eq(repeats[0]), same[1].eq(same[0])]
        m.d.comb += self.found.p.identity.answered.eq(
            Mux(
                repeats[1],
                same[1],
                (_bits(known.ends) == _bits(last.ends)) & (known.epoch == present),
            )
        )

        # Void rows belong to the last epoch, which is never the current one.
        sweeping = Signal(init=1)
        swept = Signal(self.row_bits)
        m.d.comb += [
            self.busy.eq(sweeping),
            write.en.eq(fresh | sweeping),
            write.addr.eq(Mux(sweeping, swept, taken.row)),
            write.data.ends.eq(taken.ends),
            write.data.epoch.eq(Mux(sweeping, void, present)),
        ]
        with m.If(sweeping):
            m.d.sync += [swept.eq(swept + 1), sweeping.eq(swept != self.rows - 1)]
        with m.If(self.clear):
            with m.If(present == void - 1):
                m.d.sync += [present.eq(0), sweeping.eq(1)]
            with m.Else():
                m.d.sync += present.eq(present + 1)

    def _exchange_values(self, m):
        """Store walked results, and return stored results for answered segments."""
        walked, results = self.walked, self.results
        value = Cat(walked.hits, walked.margin)
        given = delay_line(m, value, 2, "given")
        if self.rows:
            m.submodules.values = values = BlockMemory(
                rows=self.rows, width=len(value), latency=2, ports=1
            )
            answered = walked.identity.answered
            m.d.comb += [
                values.a.address.eq(walked.identity.row),
                values.a.write_data.eq(value),
                values.a.write_enable.eq(walked.valid & ~answered),
            ]
            given = Mux(delay_line(m, answered, 2, "answered"), values.a.data, given)
        arrived = Signal()
        m.d.sync += [arrived.eq(walked.valid), results.valid.eq(arrived)]
        m.d.comb += [
            Cat(results.hits, results.margin).eq(given),
            results.identity.eq(delay_line(m, walked.identity.marks, 2, "marks")),
        ]


def _bits(ends):
    return Value.cast(ends)
