"""Parser of the points of a CHECK."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import Out, connect, flipped

from hdl.command.layouts import payload_members
from hdl.command.waypoint_assembler import WaypointAssembler
from hdl.config import Config
from hdl.layouts import point_layout
from hdl.protocol import Status


__all__ = ["PointParser"]


class PointParser(wiring.Component):
    """Passes on the points of one path, 2 to ``max_waypoints + 2`` of them.

    The parser is done in the cycle after the last point is accepted. Any other number of points is
    refused; the points before the error have been passed on by then.

    Parameters
    ----------
    config : Config

    Members
    -------
    on, repeated, bytes, ended, done, status
        See :func:`hdl.command.layouts.payload_members`.
    points : Out(stream of x, y, altitude, last)
        At most as many as a path may have, and none after the ``last``; ``valid`` is a register.
    """

    def __init__(self, config: Config):
        self.config = config
        self.point_layout = point_layout(config.coordinate_bits, config.altitude_bits)
        super().__init__({**payload_members(), "points": Out(stream.Signature(self.point_layout))})

    def elaborate(self, platform):
        m = Module()
        most = self.config.max_waypoints + 2

        m.submodules.words = words = WaypointAssembler(self.config.waypoint_bits)
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
