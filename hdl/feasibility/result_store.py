"""Store of the latest check's results, for the host to read."""

from dataclasses import dataclass

from amaranth import *
from amaranth.lib import data, memory, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import Config
from pathgene.hdl.layouts import record_layout, result_read_layout, struct
from pathgene.hdl.primitives.logic import delay_line
from pathgene.hdl.primitives.unit import Count, Given, Unit
from pathgene.hdl.protocol.layout import Layout
from pathgene.hdl.protocol.messages import check_reply, entry_record, hit_record, path_record


__all__ = ["RecordLayouts", "ResultStore"]


@dataclass(frozen=True)
class RecordLayouts:
    """Layouts of a check's results on the link.

    Attributes
    ----------
    totals : Layout
        Sums over all paths: :func:`pathgene.hdl.protocol.messages.check_reply`.
    path, hit, entry : Layout
        Layouts of each path, its collision, and each segment with colliding cells:
        ``path_record``, ``hit_record`` and ``entry_record`` of
        :mod:`pathgene.hdl.protocol.messages`. They have the fields of a verdict and of a count.
    """

    totals: Layout
    path: Layout
    hit: Layout
    entry: Layout

    @classmethod
    def of(cls, config: Config) -> "RecordLayouts":
        """Return the layouts for ``config``."""
        return cls(
            check_reply(config), path_record(config), hit_record(config), entry_record(config)
        )


class ResultStore(Unit):
    """Keeps the checker's verdicts and counts of a check, and serves them byte by byte.

    Verdicts and counts are taken in every cycle, so that the link never stalls the checker: there
    is room for an entry for every segment of every path. The number of entries in each verdict
    assigns them to paths, independent of the timing of the two streams.

    On a target, counts take a block RAM for each 1024 rows of 18 bits (two for 32 paths of 17
    segments). Verdicts take ``checked_paths`` rows of two to four more block RAMs, or of
    distributed memory, at the choice of synthesis.

    Members
    -------
    clear : In(1)
        A check begins: discard the stored results from the second cycle on.
    verdicts : In(stream.Signature(verdict_layout))
    counts : In(stream.Signature(count_layout))
        Always ready.
    paths : Out(9)
        Number of stored verdicts; all other outputs include a verdict from the next cycle on.
    complete : Out(1)
        All entries of these verdicts have arrived.
    totals : Out(struct of check_reply)
        Sums over the stored verdicts.
    reads : In(stream.Signature(result_read_layout))
        Stored paths to serve: the first, and their number, 1 or more.
    records : Out(stream.Signature(record_layout))
        Their results in the format of :mod:`pathgene.hdl.protocol.paths`. The first byte is
        offered 3 cycles after a read is taken; then one byte per cycle, with 2 cycles before each
        entry and path.
    """

    checked_paths: Count(1, text="Maximum paths of a check.", name="Paths of a check")
    max_segments: Count(1, text="Segments of the longest path.", name="Segments of a path")
    verdict_layout: Given("data.StructLayout", "See :mod:`pathgene.hdl.feasibility.layouts`.")
    count_layout: Given("data.StructLayout", "See :mod:`pathgene.hdl.feasibility.layouts`.")
    record_layouts: Given("RecordLayouts")

    def interface(self):
        self.totals_layout = struct(self.record_layouts.totals)
        return {
            "clear": In(1),
            "verdicts": In(stream.Signature(self.verdict_layout)),
            "counts": In(stream.Signature(self.count_layout)),
            "paths": Out(9),
            "complete": Out(1),
            "totals": Out(self.totals_layout),
            "reads": In(stream.Signature(result_read_layout)),
            "records": Out(stream.Signature(record_layout)),
        }

    def elaborate(self, platform):
        m = Module()
        verdict, count = self.verdicts.p, self.counts.p

        rows = self.checked_paths * self.max_segments
        hit, entry = self.record_layouts.hit, self.record_layouts.entry
        names = [name for name, _ in hit.fields]
        verdict_row = data.StructLayout(
            {"first": range(rows), "collision": 1, "entries": 7, **dict(hit.fields)}
        )
        m.submodules.entry_rows = entry_rows = memory.Memory(
            shape=struct(entry), depth=rows, init=[]
        )

        received_entries = Signal(range(rows + 1), reset_less=True)
        announced_entries = Signal(range(rows + 1), reset_less=True)
        paths = Signal.like(self.paths, reset_less=True)
        totals = Signal.like(self.totals, reset_less=True)
        cleared = Signal(init=1)
        m.d.sync += cleared.eq(self.clear)
        row = Signal(verdict_row)
        entry_write = entry_rows.write_port()
        m.d.comb += [
            self.paths.eq(paths),
            self.totals.eq(totals),
            self.verdicts.ready.eq(1),
            self.counts.ready.eq(1),
            self.complete.eq(received_entries == announced_entries),
            row.first.eq(announced_entries),
            row.collision.eq(verdict.collision),
            row.entries.eq(verdict.entries),
            *(row[name].eq(verdict[name]) for name in names),
            entry_write.en.eq(self.counts.valid),
            entry_write.addr.eq(received_entries),
            *(entry_write.data[name].eq(count[name]) for name, _ in entry.fields),
        ]
        with m.If(self.verdicts.valid):
            m.d.sync += [
                paths.eq(paths + 1),
                announced_entries.eq(announced_entries + verdict.entries),
            ]

        # The remaining fields are stored one cycle later, because they are wide and far from the
        # checker.
        came, kept = Signal(), Signal.like(verdict, reset_less=True)
        kept_row = Signal(verdict_row, reset_less=True)
        kept_at = Signal(range(max(2, self.checked_paths)), reset_less=True)
        m.d.sync += [
            came.eq(self.verdicts.valid),
            kept.eq(verdict),
            kept_row.eq(row),
            kept_at.eq(paths),
        ]
        with m.If(came):
            m.d.sync += [
                totals[name].eq(totals[name] + kept[name])
                for name, _ in self.record_layouts.totals.fields
            ]
        with m.If(self.counts.valid):
            m.d.sync += received_entries.eq(received_entries + 1)
        # Also after a reset, because a reset of these registers would make `cleared` too slow.
        with m.If(cleared):
            m.d.sync += [paths.eq(0), totals.eq(0), received_entries.eq(0), announced_entries.eq(0)]

        number = Signal(8, reset_less=True)
        self._serve(
            m, number, self._keep(m, came, kept_at, kept_row, number), entry_rows.read_port()
        )
        return m

    def _keep(self, m, came, at, row, number):
        """Store the ``row`` that ``came``; return the row ``number``, at most one cycle later."""
        if self.checked_paths == 1:
            only = Signal.like(row)
            with m.If(came):
                m.d.sync += only.eq(row)
            return only

        m.submodules.verdict_rows = rows = memory.Memory(
            shape=row.shape(), depth=self.checked_paths, init=[]
        )
        write, read = rows.write_port(), rows.read_port()
        m.d.comb += [
            write.en.eq(came),
            write.addr.eq(at),
            write.data.eq(row),
            read.addr.eq(number),
        ]
        return read.data

    def _serve(self, m, number, result, entry_read):
        """Serve the requested results."""
        layouts = self.record_layouts
        path, hit, entry = layouts.path, layouts.hit, layouts.entry

        paths = Signal(9, reset_less=True)  # Paths left, including the one being sent.
        entries = Signal(7, reset_less=True)  # Entries of this path left.
        fields = Signal(8 * max(path.size + hit.size, entry.size), reset_less=True)
        # Bytes of the fields.
        left = Signal(range(path.size + hit.size + entry.size), reset_less=True)
        ends = Signal()
        m.d.comb += [
            self.records.p.data.eq(fields[:8]),
            ends.eq((left == 1) & (entries == 0)),
            self.records.p.last.eq(ends & (paths == 1)),
        ]
        # Rows leave the memory long before they are needed, so there is time for registers.
        row = Signal.like(entry_read.addr, reset_less=True)
        fetched = delay_line(m, Value.cast(entry_read.data), 2, "fetched")
        m.d.comb += entry_read.addr.eq(row)

        with m.FSM():
            with m.State("Idle"):
                m.d.comb += self.reads.ready.eq(1)
                m.d.sync += [number.eq(self.reads.p.path), paths.eq(self.reads.p.count)]
                with m.If(self.reads.valid):
                    m.next = "Path"

            with m.State("Path"):
                m.next = "Verdict"

            with m.State("Verdict"):
                m.d.sync += [
                    fields.eq(
                        Cat(
                            result.collision,
                            result.entries,
                            *(result[name] for name, _ in hit.fields),
                        )
                    ),
                    left.eq(Mux(result.collision, path.size + hit.size, path.size)),
                    entries.eq(result.entries),
                    row.eq(result.first),
                    number.eq(number + 1),
                ]
                m.next = "Bytes"

            with m.State("Bytes"):
                m.d.comb += self.records.valid.eq(1)
                with m.If(self.records.ready):
                    m.d.sync += [fields.eq(fields >> 8), left.eq(left - 1)]
                    with m.If(ends):
                        m.d.sync += paths.eq(paths - 1)
                        m.next = "Path"
                        with m.If(paths == 1):
                            m.next = "Idle"
                    with m.Elif(left == 1):
                        m.next = "Entry"

            with m.State("Entry"):
                m.d.sync += [row.eq(row + 1), entries.eq(entries - 1)]
                m.next = "Counts"

            with m.State("Counts"):
                m.d.sync += [fields.eq(fetched), left.eq(entry.size)]
                m.next = "Bytes"
