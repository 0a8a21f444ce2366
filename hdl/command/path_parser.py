"""Parser of the paths of a WRITE."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.command.layouts import payload_members
from pathgene.hdl.command.waypoint_assembler import WaypointAssembler
from pathgene.hdl.layouts import write_layout
from pathgene.hdl.primitives.unit import Count, Unit, Width
from pathgene.hdl.protocol import Status


__all__ = ["PathParser"]


class PathParser(Unit):
    """Writes paths into consecutive slots.

    The parser is done in the cycle after the last waypoint is written. Paths of a wrong length, or
    past the last slot, are refused; the waypoints before the error have been written by then.

    Members
    -------
    on, repeated, bytes, ended, done, status
        See :func:`pathgene.hdl.command.layouts.payload_members`.
    slot : In(8)
        The first slot; steady from the cycle before ``on``.
    writes : Out(stream of slot, index, waypoint, last)
        Waypoints for the present population; ``valid`` is a register.
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

        # No reset is needed: `on` is low after a reset, and clears them.
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
