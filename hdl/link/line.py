"""The chip's end of the line: UART or byte-wide port, frames and byte counters."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.link.frame import FrameReceiver, FrameTransmitter, body_layout
from pathgene.hdl.link.uart import UartReceiver, UartTransmitter
from pathgene.hdl.primitives.buffers import SkidBuffer, StreamRegister
from pathgene.hdl.primitives.unit import Count, PowerOfTwo, Unit
from pathgene.hdl.protocol.codes import COUNTER_BITS


__all__ = ["Line"]


class Line(Unit):
    """Converts between the bytes of the line and the bodies of whole frames.

    Members
    -------
    rx, tx : In(1), Out(1)
        The pins of the UART; ``rx`` is asynchronous.
    received, sent : In(stream.Signature(8)), Out(stream.Signature(8))
        A byte-wide port instead of the UART, up to a byte per cycle in each direction. All its
        outputs come from registers.
    requests : Out(stream)
        Bodies from the host: :class:`pathgene.hdl.link.frame.FrameReceiver`.
    replies : In(stream)
        Bodies for the host: :class:`pathgene.hdl.link.frame.FrameTransmitter`.
    errors : Out(4)
        Pulses, in the order of :class:`pathgene.hdl.protocol.codes.StickyError`: FRAMING, OVERRUN,
        CRC, MALFORMED.
    busy : Out(1)
        A frame has begun but not ended.
    sending : Out(1)
        A byte is being sent or is waiting.
    bytes_received, bytes_sent : Out(48)
        All bytes on the line since reset. A byte counts when its stop bit is received or its start
        bit is about to be sent, or when the byte-wide port takes or passes it.
    """

    clocks_per_bit: Count(
        4, 65535, "Divisor of the UART: cycles per bit; 0 for a byte-wide port.", also=(0,)
    )
    receive_buffer: PowerOfTwo(8, 1 << 15, "Bytes of received bodies that the chip can hold.")

    def interface(self):
        if self.clocks_per_bit:
            port = {"rx": In(1, init=1), "tx": Out(1, init=1)}
        else:
            port = {"received": In(stream.Signature(8)), "sent": Out(stream.Signature(8))}
        return {
            **port,
            "requests": Out(stream.Signature(body_layout)),
            "replies": In(stream.Signature(body_layout)),
            "errors": Out(4),
            "busy": Out(1),
            "sending": Out(1),
            "bytes_received": Out(COUNTER_BITS),
            "bytes_sent": Out(COUNTER_BITS),
        }

    def elaborate(self, platform):
        m = Module()

        framing_error = Signal()
        if self.clocks_per_bit:
            m.submodules.uart_receiver = uart_receiver = UartReceiver(self.clocks_per_bit)
            m.submodules.uart_transmitter = uart_transmitter = UartTransmitter(self.clocks_per_bit)
            m.d.comb += [
                uart_receiver.rx.eq(self.rx),
                self.tx.eq(uart_transmitter.tx),
                framing_error.eq(uart_receiver.framing_error),
                self.sending.eq(uart_transmitter.bytes.valid | ~uart_transmitter.bytes.ready),
            ]
            received, sent = uart_receiver.bytes, uart_transmitter.bytes
        else:
            received, sent = flipped(self.received), flipped(self.sent)
            m.d.comb += self.sending.eq(sent.valid)
        m.submodules.frame_receiver = frame_receiver = FrameReceiver(self.receive_buffer)
        m.submodules.frame_transmitter = frame_transmitter = FrameTransmitter()

        # Large units consume the requests and produce the replies; registers on both sides keep
        # their `valid` and `ready` off long combinational paths through the line.
        m.submodules.request_buffer = request_buffer = SkidBuffer(body_layout)
        m.submodules.request_register = request_register = StreamRegister(body_layout)
        m.submodules.reply_buffer = reply_buffer = SkidBuffer(body_layout)
        m.submodules.reply_register = reply_register = StreamRegister(body_layout)

        m.d.comb += [
            self.busy.eq(frame_receiver.line_busy),
            self.errors.eq(
                Cat(
                    framing_error,
                    frame_receiver.overrun,
                    frame_receiver.crc_error,
                    frame_receiver.malformed,
                )
            ),
        ]
        connect(m, received, frame_receiver.bytes)
        connect(m, frame_receiver.requests, request_buffer.words)
        connect(m, request_buffer.passed, request_register.words)
        connect(m, request_register.passed, flipped(self.requests))
        connect(m, flipped(self.replies), reply_buffer.words)
        connect(m, reply_buffer.passed, reply_register.words)
        connect(m, reply_register.passed, frame_transmitter.replies)
        connect(m, frame_transmitter.bytes, sent)

        with m.If(received.valid):
            m.d.sync += self.bytes_received.eq(self.bytes_received + 1)
        with m.If(sent.valid & sent.ready):
            m.d.sync += self.bytes_sent.eq(self.bytes_sent + 1)

        return m
