"""Parser of the points of a CHECK."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import Out, connect, flipped

from pathgene.hdl.command.layouts import payload_members
from pathgene.hdl.command.waypoint_assembler import WaypointAssembler
from pathgene.hdl.layouts import point_layout
from pathgene.hdl.primitives.unit import Count, Unit, Width
from pathgene.hdl.protocol import Status


__all__ = ["PointParser"]


class PointParser(Unit):
    """Passes on the points of one path, 2 to ``max_waypoints + 2`` of them.

    The parser is done in the cycle after the last point is accepted. Any other number of points is
    refused; the points before the error have been passed on by then.

    Members
    -------
    on, repeated, bytes, ended, done, status
        See :func:`pathgene.hdl.command.layouts.payload_members`.
    points : Out(stream of x, y, altitude, last)
        At most as many as a path may have, and none after the ``last``; ``valid`` is a register.
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
