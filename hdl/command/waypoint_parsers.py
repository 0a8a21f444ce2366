"""Parsers of waypoints: the paths of a WRITE and the points of a CHECK."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.command.layouts import payload_members
from pathgene.hdl.layouts import point_layout, write_layout
from pathgene.hdl.primitives.unit import Count, Unit, Width
from pathgene.hdl.protocol.codes import Status


__all__ = ["PathParser", "PointParser", "WaypointAssembler"]


class WaypointAssembler(Unit):
    """Assembles waypoints from bytes: one cycle per byte, and two more per waypoint.

    In the first of these two cycles the user says whether the waypoint is wrong. In the second, the
    waypoint is offered, so that ``valid`` is a register.

    Members
    -------
    on : In(1)
        While low, the unit is in its reset state.
    bytes : In(stream.Signature(8))
        Whole bytes of each waypoint, lowest first; ``last`` is the bit above its ``waypoint_bits``.
    partial : Out(1)
        Some bytes of a waypoint have arrived, but not all.
    busy : Out(1)
        A waypoint is complete and has not been passed on.
    judge : Out(1)
        High for one cycle, the first of ``busy``: ``wrong`` is sampled.
    wrong : In(1)
        The waypoint is discarded.
    repeated : In(1)
        Offer no waypoint. Steady while ``on``.
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


class PathParser(Unit):
    """Writes paths into consecutive slots.

    The parser is done in the cycle after the last waypoint is written. Paths of wrong length, or
    past the last slot, are refused; waypoints before the error have been written by then.

    Members
    -------
    on, repeated, bytes, ended, done, status
        See :func:`pathgene.hdl.command.layouts.payload_members`.
    slot : In(8)
        The first slot; steady from the cycle before ``on``.
    writes : Out(stream of slot, index, waypoint, last)
        Waypoints for the current population; ``valid`` is a register.
    """

    population: Count(2, 256, "Slots.")
    waypoint_bits: Width(1)
    min_waypoints: Count(1, text="Waypoints of the shortest path.")
    max_waypoints: Count(2, text="Waypoints of the longest path.")

    def interface(self):
        slot_bits = (self.population - 1).bit_length()
        index_bits = (self.max_waypoints - 1).bit_length()
        self.write_layout = write_layout(slot_bits, index_bits, self.waypoint_bits)
        return {
            **payload_members(),
            "slot": In(8),
            "writes": Out(stream.Signature(self.write_layout)),
        }

    def elaborate(self, platform):
        m = Module()
        m.submodules.words = words = WaypointAssembler(self.waypoint_bits)
        word = words.words
        connect(m, flipped(self.bytes), words.bytes)

        # No reset is needed, because `on` is low after a reset and clears them.
        slot = Signal(9, reset_less=True)  # Slot of this path.
        index = Signal(range(self.max_waypoints + 1), reset_less=True)
        any_word = Signal(reset_less=True)
        bad_value = Signal(reset_less=True)
        m.d.comb += [
            words.on.eq(self.on),
            words.repeated.eq(self.repeated),
            words.wrong.eq(
                (slot >= self.population)
                | (index >= self.max_waypoints)
                | (word.p.last & (index < self.min_waypoints - 1))
                | bad_value
            ),
            self.writes.p.slot.eq(slot),
            self.writes.p.index.eq(index),
            self.writes.p.waypoint.eq(word.p.waypoint),
            self.writes.p.last.eq(word.p.last),
            self.writes.valid.eq(word.valid),
            word.ready.eq(self.writes.ready),
        ]
        with m.If(~self.on):
            m.d.sync += [slot.eq(self.slot), index.eq(0), any_word.eq(0), bad_value.eq(0)]
        with m.Elif(words.judge):
            m.d.sync += [any_word.eq(1), bad_value.eq(words.wrong)]
        with m.Elif(words.passes):
            m.d.sync += index.eq(index + 1)
            with m.If(word.p.last):
                m.d.sync += [index.eq(0), slot.eq(slot + 1)]

        m.d.comb += [
            self.done.eq(self.on & self.ended & ~words.busy),
            self.status.eq(Status.OK),
        ]
        with m.If(words.partial | ~any_word):
            m.d.comb += self.status.eq(Status.BAD_LENGTH)
        with m.Elif(bad_value | (index != 0)):
            m.d.comb += self.status.eq(Status.BAD_VALUE)

        return m


class PointParser(Unit):
    """Passes on the points of one path, 2 to ``max_waypoints + 2`` of them.

    The parser is done in the cycle after the last point is accepted. Any other number of points is
    refused; the points before the error have been passed on by then.

    Members
    -------
    on, repeated, bytes, ended, done, status
        See :func:`pathgene.hdl.command.layouts.payload_members`.
    points : Out(stream of x, y, altitude, last)
        At most the number that a path may have, and none after the ``last``; ``valid`` is a
        register.
    """

    coordinate_bits: Width(1)
    altitude_bits: Width(1)
    max_waypoints: Count(1, text="Waypoints of the longest path, without its two ends.")

    def interface(self):
        self.point_layout = point_layout(self.coordinate_bits, self.altitude_bits)
        return {**payload_members(), "points": Out(stream.Signature(self.point_layout))}

    def elaborate(self, platform):
        m = Module()
        most = self.max_waypoints + 2

        waypoint_bits = 2 * self.coordinate_bits + self.altitude_bits
        m.submodules.words = words = WaypointAssembler(waypoint_bits)
        word = words.words
        connect(m, flipped(self.bytes), words.bytes)

        count = Signal(range(most + 1))
        finished = Signal()
        bad_value = Signal()
        m.d.comb += [
            words.on.eq(self.on),
            words.repeated.eq(self.repeated),
            words.wrong.eq(finished | (count == most) | (word.p.last & (count == 0)) | bad_value),
            self.points.p.eq(word.p),
            self.points.valid.eq(word.valid),
            word.ready.eq(self.points.ready),
        ]
        with m.If(~self.on):
            m.d.sync += [count.eq(0), finished.eq(0), bad_value.eq(0)]
        with m.Elif(words.judge):
            m.d.sync += bad_value.eq(words.wrong)
        with m.Elif(words.passes):
            m.d.sync += [finished.eq(word.p.last), count.eq(count + 1)]

        m.d.comb += [
            self.done.eq(self.on & self.ended & ~words.busy),
            self.status.eq(Status.OK),
        ]
        with m.If(words.partial | ((count == 0) & ~bad_value)):
            m.d.comb += self.status.eq(Status.BAD_LENGTH)
        with m.Elif(bad_value | ~finished):
            m.d.comb += self.status.eq(Status.BAD_VALUE)

        return m
