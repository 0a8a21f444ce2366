"""Puts waypoints together from the bytes of the link."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config


__all__ = ["WaypointWords"]


class WaypointWords(wiring.Component):
    """Bytes in, waypoints out: a byte a clock, and a clock for each waypoint.

    Parameters
    ----------
    config : Config

    Members
    -------
    on : In(1)
        While low, the unit is as after reset.
    bytes : In(stream.Signature(8))
        ``waypoint_bytes`` for each waypoint, lowest first.
    words : Out(stream of waypoint, last)
        Offered in the clock after the last byte.
    partial : Out(1)
        Bytes of a waypoint have come, but not all of them.
    """

    def __init__(self, config: Config):
        self.config = config
        self.word_layout = data.StructLayout({"waypoint": config.waypoint_bits, "last": 1})
        super().__init__(
            {
                "on": In(1),
                "bytes": In(stream.Signature(8)),
                "words": Out(stream.Signature(self.word_layout)),
                "partial": Out(1),
            }
        )

    def elaborate(self, platform):
        m = Module()
        size = self.config.waypoint_bytes

        word = Signal(8 * size)
        part = Signal(range(size))
        m.d.comb += [
            self.bytes.ready.eq(~self.words.valid),
            self.words.p.eq(word),
            self.partial.eq(part != 0),
        ]
        with m.If(self.bytes.valid & self.bytes.ready):
            m.d.sync += [word.eq(Cat(word[8:], self.bytes.payload)), part.eq(part + 1)]
            with m.If(part == size - 1):
                m.d.sync += [part.eq(0), self.words.valid.eq(1)]
        with m.If(self.words.valid & self.words.ready):
            m.d.sync += self.words.valid.eq(0)
        with m.If(~self.on):
            m.d.sync += [part.eq(0), self.words.valid.eq(0)]

        return m
