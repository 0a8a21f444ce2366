"""The memo never answers for a different segment, nor with a different segment's value."""

from typing import NamedTuple

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover
from amaranth.lib import data

from pathgene.hdl.planner.walker.memo import Memo
from tests.formal.parts import Opened, any_constant, free
from tools.formal import Proof


class Answers(Elaboratable):
    """Proved for all time, by induction, for 2 rows, 3 epochs and points of one bit per axis.

    Segments arrive and leave at any time; walked segments return at any time with any contents.
    Assumed: an epoch only begins while nothing is being looked up and no row is being cleared.

    - A segment is answered if and only if the previous segment in its row, in order of arrival, is
      the same segment in the same epoch.
    - When an answered segment returns, its result is the latest value returned before for its row
      by an unanswered segment; any other segment has its own value.

    Segments return in the order in which they are found, because the walker keeps their order;
    therefore the value belongs to the same segment.
    """

    def __init__(self, unit):
        self.dut = unit(Memo)(2, 1, 1, epoch_bits=2)

    def elaborate(self, platform):
        m = Module()
        memo = self.dut
        m.submodules.dut = dut = Opened(memo)
        found, walked, results = memo.found, memo.walked, memo.results
        request, identity = memo.segments.p, found.p.identity
        free(m, memo.segments.valid, request.start, request.stop, found.ready, memo.clear)
        watched = any_constant(m, 1, "watched")
        values = dut.open("values")
        tag, stored = dut.memory(m, "tags", watched), values.memory(m, "rows", watched)

        # Number of segments looked up but not found.
        looked_up = Signal(3)
        taken = memo.segments.valid & memo.segments.ready
        passed = found.valid & found.ready
        idle = (looked_up == 0) & ~memo.segments.valid & ~memo.busy
        m.d.sync += looked_up.eq(looked_up + taken - passed)
        m.d.comb += Assume(~memo.clear | idle)

        # The latest segment of the watched row.
        ends = Cat(found.p.start, found.p.stop)
        latest, is_there = Signal(6), Signal()
        here = passed & (identity.row == watched)
        with m.If(memo.clear):
            m.d.sync += is_there.eq(0)
        with m.Elif(here):
            m.d.sync += [latest.eq(ends), is_there.eq(1)]
        with m.If(here):
            m.d.comb += Assert(identity.answered == (is_there & (latest == ends)))
        self._induce(m, dut, looked_up, watched, tag, _Latest(is_there, latest))

        # The latest value of the watched row. Results are two cycles late.
        free(m, walked.valid, walked.identity, walked.hits, walked.margin)
        value, known = Signal(4), Signal()
        now, row = Cat(walked.hits, walked.margin), walked.identity.row
        with m.If(walked.valid & ~walked.identity.answered & (row == watched)):
            m.d.sync += [value.eq(now), known.eq(1)]
        valid, expects = (Signal(2, name=name) for name in ("valid", "expects"))
        expected = [Signal(4, name=f"expected_{number}") for number in range(2)]
        is_expected = ~walked.identity.answered | (known & (row == watched))
        m.d.sync += [
            valid.eq(Cat(walked.valid, valid)),
            expects.eq(Cat(walked.valid & is_expected, expects)),
            expected[0].eq(Mux(walked.identity.answered, value, now)),
            expected[1].eq(expected[0]),
        ]
        m.d.comb += [Assert(results.valid == valid[1]), Assert(~known | (stored == value))]
        with m.If(expects[1]):
            m.d.comb += Assert(Cat(results.hits, results.margin) == expected[1])
        read = values.submodules.rows.read_ports[0].data
        answered, given = (dut.signal(f"{name}_1") for name in ("answered", "given"))
        m.d.comb += Assert(dut.signal("arrived") == valid[0])
        with m.If(expects[0]):
            m.d.comb += Assert(Mux(answered, read, given) == expected[0])

        epochs = Signal(2)
        m.d.sync += epochs.eq(epochs + memo.clear)
        m.d.comb += Cover((epochs == 1) & here & identity.answered)
        return m

    def _induce(self, m, dut, looked_up, watched, tag, latest):
        """Claim the invariants of segments in flight, and of the tag, for the induction."""
        memo = self.dut
        names = ("full", "fresh", "repeats", "same", "known", "sweeping", "swept", "present")
        full, fresh, repeats, same, known, sweeping, swept, present = map(dut.signal, names)
        layouts = memo.stage_layout, memo.tag_layout
        stages = [data.View(layouts[0], dut.signal(f"stage_{number}")) for number in range(3)]
        tag, known = (data.View(layouts[1], each) for each in (tag, known))
        void = 3

        def after(stage, is_full, before):
            """Return the latest segment of the row that has passed a stage."""
            is_here = is_full & (stage.row == watched)
            return _Latest(
                is_here | before.is_there, Mux(is_here, Value.cast(stage.ends), before.ends)
            )

        def is_tag_of(found, before):
            """Return whether a tag matches the latest segment of the row."""
            is_valid = found.epoch == present
            return (is_valid == before.is_there) & (
                ~is_valid | (Value.cast(found.ends) == before.ends)
            )

        m.d.comb += [
            Assert(looked_up == sum(full)),
            Assert(present != void),
            Assert(memo.busy == sweeping),
            Assert(~fresh | full[1]),
        ]
        # The two segments whose row has been read, the earlier one first.
        past = latest
        for at, found in ((2, known), (1, dut.submodules.tags.read_ports[0].data)):
            stage, number = stages[at], at - 1
            with m.If(full[at] & (stage.row == watched)):
                is_same = past.is_there & (past.ends == Value.cast(stage.ends))
                m.d.comb += [
                    Assert(~repeats[number] | (same[number] == is_same)),
                    Assert(repeats[number] | is_tag_of(found, past)),
                ]
            unwritten, past = past, after(stage, full[at], past)
        with m.If(sweeping):
            m.d.comb += [
                Assert(~full.any()),
                Assert(~fresh),
                Assert(~latest.is_there),
                Assert((swept <= watched) | (tag.epoch == void)),
            ]
        with m.Else():
            m.d.comb += [
                Assert(swept == 0),
                Assert((tag.epoch == void) | (tag.epoch <= present)),
                Assert(Mux(fresh, is_tag_of(tag, unwritten), is_tag_of(tag, past))),
            ]


class _Latest(NamedTuple):
    """The latest segment of a row: whether there is one, and its ends."""

    is_there: Value
    ends: Value


PROOF = Proof(
    claim=Answers,
    depth=6,
    induction=2,
    reached=14,
    faults={
        "half of the tag": (
            Memo,
            (
                "(_bits(known.ends) == _bits(last.ends))",
                "(_bits(known.ends)[3:] == _bits(last.ends)[3:])",
            ),
        ),
        "an old epoch answers": (Memo, (" & (known.epoch == present)", "")),
        "the segment before is not seen": (Memo, ("repeats[1],\n", "0,\n")),
        "the segment before answers for its row": (
            Memo,
            ("same[1],\n", "1,\n"),
        ),
        "answers are kept as well": (
            Memo,
            ("write_enable.eq(walked.valid & ~answered)", "write_enable.eq(walked.valid)"),
        ),
    },
)
