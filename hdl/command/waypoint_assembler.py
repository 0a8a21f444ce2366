"""Assembler of waypoints from the bytes of the link."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Unit, Width


__all__ = ["WaypointAssembler"]


class WaypointAssembler(Unit):
    """Assembles waypoints from bytes: one cycle per byte, and two more for each waypoint.

    In the first of these two cycles the user says whether the waypoint is wrong. In the second, the
    waypoint is offered, so that ``valid`` is a register.

    Members
    -------
    on : In(1)
        While low, the unit is in its reset state.
    bytes : In(stream.Signature(8))
        Whole bytes of each waypoint, lowest first; ``last`` is the bit above its ``waypoint_bits``.
    partial : Out(1)
        Some bytes of a waypoint have come, but not all.
    busy : Out(1)
        A waypoint is complete and has not been passed on.
    judge : Out(1)
        High for one cycle, the first of ``busy``: ``wrong`` is sampled.
    wrong : In(1)
        The waypoint is discarded.
    repeated : In(1)
        No waypoint is offered. Steady while ``on``.
    words : Out(stream of waypoint, last)
        The payload is steady while ``busy``.
    passes : Out(1)
        A waypoint that is not wrong leaves, whether it was offered or ``repeated``.
    """

    waypoint_bits: Width(1, text="Without the ``last`` flag.")

    def interface(self):
        self.word_layout = data.StructLayout({"waypoint": self.waypoint_bits, "last": 1})
        return {
            "on": In(1),
            "bytes": In(stream.Signature(8)),
            "partial": Out(1),
            "busy": Out(1),
            "judge": Out(1),
            "wrong": In(1),
            "repeated": In(1),
            "words": Out(stream.Signature(self.word_layout)),
            "passes": Out(1),
        }

    def elaborate(self, platform):
        m = Module()
        size = (self.word_layout.size + 7) // 8

        word = Signal(8 * size, reset_less=True)
        part = Signal(range(size), reset_less=True)
        m.d.comb += [
            self.bytes.ready.eq(~self.busy),
            self.words.p.eq(word),
            self.partial.eq(part != 0),
            self.passes.eq(self.busy & ~self.judge & (self.repeated | self.words.ready)),
        ]
        m.d.sync += self.judge.eq(0)
        with m.If(self.bytes.valid & self.bytes.ready):
            m.d.sync += [word.eq(Cat(word[8:], self.bytes.payload)), part.eq(part + 1)]
            with m.If(part == size - 1):
                m.d.sync += [part.eq(0), self.busy.eq(1), self.judge.eq(1)]
        with m.If(self.judge):
            m.d.sync += [
                self.busy.eq(~self.wrong),
                self.words.valid.eq(~self.wrong & ~self.repeated),
            ]
        with m.If(self.passes):
            m.d.sync += [self.busy.eq(0), self.words.valid.eq(0)]
        with m.If(~self.on):
            m.d.sync += [part.eq(0), self.busy.eq(0), self.judge.eq(0), self.words.valid.eq(0)]

        return m
