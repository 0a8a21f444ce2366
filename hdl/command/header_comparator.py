"""Comparison of a request's header with the expected one."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Unit


__all__ = ["HeaderComparator"]


class HeaderComparator(Unit):
    """Compares a header with the expected one by the rules of :mod:`pathgene.hdl.protocol`.

    Every output is a register and follows its inputs 1 cycle later: one byte is compared while the
    next byte arrives.

    Members
    -------
    session, sequence : In(8)
        First two bytes of the request.
    open_session, expected : In(8)
        Open session, and sequence number of the next command.
    same_session, next_session : Out(1)
        The session is the open one, or the one after it.
    present, previous, future : Out(1)
        The number is the expected one, the one before it, or one of the 128 after it.
    """

    session: In(8)
    sequence: In(8)
    open_session: In(8)
    expected: In(8)
    same_session: Out(1)
    next_session: Out(1)
    present: Out(1)
    previous: Out(1)
    future: Out(1)

    def elaborate(self, platform):
        m = Module()

        ahead = Signal(8)
        m.d.comb += ahead.eq(self.sequence - self.expected)
        m.d.sync += [
            self.same_session.eq(self.session == self.open_session),
            self.next_session.eq(self.session == (self.open_session + 1)[:8]),
            self.present.eq(ahead == 0),
            self.previous.eq(ahead == 255),
            self.future.eq((ahead != 0) & (ahead < 129)),
        ]

        return m
