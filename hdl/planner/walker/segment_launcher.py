"""From the ends of segments to the groups of corners that lanes take each cycle."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.feasibility.parallel.reciprocal import Precision, Reciprocals
from pathgene.hdl.feasibility.parallel.segment_setup import SegmentShaper, segment_layout
from pathgene.hdl.planner.walker.layouts import (
    corner_layout,
    identity_layout,
    segment_request_layout,
)
from pathgene.hdl.primitives.fanout import fanout
from pathgene.hdl.primitives.unit import Width


__all__ = ["SegmentLauncher", "launch_layout"]


def launch_layout(identity: data.StructLayout) -> data.StructLayout:
    """Return the layout of the facts that go with a group of corners through all stages.

    ``valid``, ``starts_segment``, ``ends_segment``, and the ``identity`` of its segment.
    """
    return data.StructLayout(
        {"valid": 1, "starts_segment": 1, "ends_segment": 1, "identity": identity}
    )


class SegmentLauncher(SegmentShaper):
    """Launches segments, back to back.

    A segment waits for its turn in two stages, as in
    :class:`pathgene.hdl.feasibility.parallel.segment_setup.SegmentSetup`. The second stage launches
    it: one group of corners per cycle, or a single empty group if the memo answers for it. Then the
    next segment follows. Nothing after this unit waits. A segment is launched 2 cycles after it is
    taken, or later if it is not yet its turn.

    Members
    -------
    segments : In(stream.Signature(segment_request_layout))
    token : Out(launch_layout)
        The group that is launched.
    segment : Out(segment_layout)
        With ``token.starts_segment``.
    """

    row_bits: Width(1, text="Row of the memo.")

    half_steps = True

    def interface(self):
        self.point_layout = corner_layout(self.coordinate_bits, self.altitude_bits)
        self.identity_layout = identity_layout(self.row_bits)
        sizes = (self.coordinate_bits, self.altitude_bits)
        request = segment_request_layout(*sizes, self.identity_layout)
        return {
            "segments": In(stream.Signature(request)),
            "token": Out(launch_layout(self.identity_layout)),
            "segment": Out(segment_layout(self.lanes, *sizes, half_steps=True)),
        }

    def elaborate(self, platform):
        m = Module()
        request = self.segments.p

        # Whether the stages hold a segment, and whether the last group of one has been launched,
        # with separate registers for the stage that is wider.
        waiting_next, free_next = Signal(), Signal()
        has_waiting, waiting_full = fanout(m, *[waiting_next] * 2, name="waiting")
        free, freed = fanout(m, *[free_next] * 2, name="free", init=1)
        has_measured = Signal()
        load, move_on, launch = Signal(), Signal(), Signal()
        m.submodules.reciprocals = reciprocals = Reciprocals(
            self.coordinate_bits,
            Precision.of(self.lanes, self.coordinate_bits, self.altitude_bits, half_steps=True),
        )
        m.d.comb += [
            load.eq(~has_measured | ~waiting_full | freed),
            move_on.eq(~has_waiting | free),
            launch.eq(has_waiting & free),
            self.segments.ready.eq(load),
            reciprocals.load.eq(load),
            reciprocals.move.eq(move_on),
            waiting_next.eq(Mux(move_on, has_measured, has_waiting)),
        ]
        with m.If(load):
            m.d.sync += has_measured.eq(self.segments.valid)

        measured = Signal(self.identity_layout, reset_less=True)
        waiting = Signal(self.identity_layout, reset_less=True)
        # Signs of sum and difference of the gains.
        x, y = (request.stop[axis] - request.start[axis] for axis in "xy")
        sides = self._measure(
            m,
            load,
            request.start,
            request.stop,
            [(y + x)[-1], (y - x)[-1]],
            reciprocals,
            [measured.eq(request.identity)],
        )
        shape = self._shape(m, move_on, sides)
        with m.If(move_on):
            m.d.sync += waiting.eq(measured)
        m.d.comb += [
            self.segment.reciprocal.eq(reciprocals.reciprocal),
            *(self.segment[name].eq(shape[name]) for name, _ in shape.shape()),
        ]

        token = self.token
        left = Signal(self.coordinate_bits)  # Groups of the segment launched last.
        launched = Signal(self.identity_layout, reset_less=True)
        groups = Mux(waiting.answered, 0, shape.length >> exact_log2(self.lanes))
        m.d.comb += token.valid.eq(launch | ~free)
        with m.If(launch):
            m.d.sync += [left.eq(groups), launched.eq(waiting)]
            m.d.comb += [
                free_next.eq(groups == 0),
                token.starts_segment.eq(1),
                token.ends_segment.eq(groups == 0),
                token.identity.eq(waiting),
            ]
        with m.Else():
            m.d.sync += left.eq(left - ~free)
            m.d.comb += [
                free_next.eq(left <= 1),
                token.ends_segment.eq(left == 1),
                token.identity.eq(launched),
            ]

        return m
