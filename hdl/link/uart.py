"""8N1 UART: receiver and transmitter."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from pathgene.hdl.primitives.unit import Count, Unit


__all__ = ["Uart", "UartReceiver", "UartTransmitter"]

# Start bit, eight data bits, stop bit.
_FRAME_BITS = 10


class UartReceiver(Unit):
    """Receives bytes from an asynchronous 8N1 line.

    The line goes through a synchronizer and a median filter over three cycles, which removes
    one-cycle spikes. Each bit is sampled at its middle, counted from the edge of the start bit; a
    start bit that has ended by its middle was noise. The search for the next start bit begins in
    the middle of the stop bit, so bytes may follow each other without pauses.

    If the stop bit is low, the byte is discarded, and the line must become high before another
    start bit counts: a break of any length is one error.

    The sampling point is at most 1 cycle off. The stop bit is sampled 9.5 bits after the edge, so
    the two clocks may differ by 2 % with every divisor, and by nearly 5 % with large ones.

    A byte is offered ``9 * clocks_per_bit + (clocks_per_bit - 1) // 2 + 4`` cycles after the first
    cycle in which ``rx`` is low.

    Members
    -------
    rx : In(1)
        The line; asynchronous, high when idle.
    bytes : Out(stream.Signature(8))
        Received bytes. The line does not wait: a byte that is not taken in time is replaced when
        the next byte is complete, at least ``9 * clocks_per_bit`` cycles later.
    framing_error : Out(1)
        High for one cycle when a stop bit was low.
    """

    clocks_per_bit: Count(4, 65535, "Divisor of the clock.")

    rx: In(1, init=1)
    bytes: Out(stream.Signature(8))
    framing_error: Out(1)

    def elaborate(self, platform):
        m = Module()

        line = Signal(init=1)
        past = Signal(2, init=0b11)
        level = Signal()
        # Bits left to sample, including the current one; 0 between bytes.
        left = Signal(range(_FRAME_BITS + 1))
        wait = Signal(range(self.clocks_per_bit))
        shift = Signal(8)
        waiting = Signal()  # Waits for the end of a break.

        m.submodules.synchronizer = FFSynchronizer(self.rx, line, init=1)
        m.d.sync += past.eq(Cat(line, past[0]))
        m.d.comb += level.eq((line & past[0]) | (past[0] & past[1]) | (line & past[1]))

        m.d.sync += self.framing_error.eq(0)
        with m.If(self.bytes.ready):
            m.d.sync += self.bytes.valid.eq(0)

        with m.If(left == 0):
            with m.If(level):
                m.d.sync += waiting.eq(0)
            with m.Elif(~waiting):
                m.d.sync += [
                    left.eq(_FRAME_BITS),
                    wait.eq((self.clocks_per_bit - 1) // 2 - 1),
                ]
        with m.Elif(wait != 0):
            m.d.sync += wait.eq(wait - 1)
        with m.Else():
            m.d.sync += [
                left.eq(left - 1),
                wait.eq(self.clocks_per_bit - 1),
            ]
            with m.If(left == 1):
                with m.If(level):
                    m.d.sync += [
                        self.bytes.valid.eq(1),
                        self.bytes.payload.eq(shift),
                    ]
                with m.Else():
                    m.d.sync += [
                        self.framing_error.eq(1),
                        waiting.eq(1),
                    ]
            with m.Else():
                m.d.sync += shift.eq(Cat(shift[1:], level))
                with m.If((left == _FRAME_BITS) & level):
                    m.d.sync += left.eq(0)

        return m


class UartTransmitter(Unit):
    """Sends bytes over an asynchronous 8N1 line.

    The start bit begins 1 cycle after a byte is accepted. A byte occupies the line for exactly
    ``10 * clocks_per_bit`` cycles and the next byte is accepted in the last of them, so a stream
    that is always valid does not leave an idle cycle on the line.

    Members
    -------
    bytes : In(stream.Signature(8))
        Bytes to send.
    tx : Out(1)
        The line; a register, high when idle.
    """

    clocks_per_bit: Count(4, 65535, "Divisor of the clock.")

    bytes: In(stream.Signature(8))
    tx: Out(1, init=1)

    def elaborate(self, platform):
        m = Module()

        bits = Signal(_FRAME_BITS, init=-1)
        # Bits left to send, including the one on the line; 0 when idle.
        left = Signal(range(_FRAME_BITS + 1))
        wait = Signal(range(self.clocks_per_bit))

        m.d.comb += [
            self.tx.eq(bits[0]),
            self.bytes.ready.eq((left <= 1) & (wait == 0)),
        ]

        with m.If(wait != 0):
            m.d.sync += wait.eq(wait - 1)
        with m.Elif(left > 1):
            m.d.sync += [
                bits.eq(Cat(bits[1:], C(1))),
                left.eq(left - 1),
                wait.eq(self.clocks_per_bit - 1),
            ]
        with m.Elif(self.bytes.valid):
            m.d.sync += [
                bits.eq(Cat(C(0), self.bytes.payload, C(1))),
                left.eq(_FRAME_BITS),
                wait.eq(self.clocks_per_bit - 1),
            ]
        with m.Else():
            m.d.sync += left.eq(0)

        return m


class Uart(Unit):
    """Both directions of an 8N1 line: :class:`UartReceiver` and :class:`UartTransmitter`.

    Members
    -------
    rx : In(1)
        The line in.
    tx : Out(1)
        The line out.
    received : Out(stream.Signature(8))
        ``bytes`` of the receiver.
    framing_error : Out(1)
        ``framing_error`` of the receiver.
    sent : In(stream.Signature(8))
        ``bytes`` of the transmitter.
    """

    clocks_per_bit: Count(4, 65535, "Divisor of the clock.")

    rx: In(1, init=1)
    tx: Out(1, init=1)
    received: Out(stream.Signature(8))
    framing_error: Out(1)
    sent: In(stream.Signature(8))

    def elaborate(self, platform):
        m = Module()

        m.submodules.receiver = receiver = UartReceiver(self.clocks_per_bit)
        m.submodules.transmitter = transmitter = UartTransmitter(self.clocks_per_bit)

        m.d.comb += [
            receiver.rx.eq(self.rx),
            self.framing_error.eq(receiver.framing_error),
            self.tx.eq(transmitter.tx),
        ]
        wiring.connect(m, receiver.bytes, wiring.flipped(self.received))
        wiring.connect(m, wiring.flipped(self.sent), transmitter.bytes)

        return m
