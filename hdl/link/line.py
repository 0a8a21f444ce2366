"""The chip's end of the line: UART, frames and byte counters."""

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
    """Converts between the UART pins and the bodies of whole frames.

    Members
    -------
    rx, tx : In(1), Out(1)
        The pins; ``rx`` is asynchronous.
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
        bit is about to be sent.
    """

    clocks_per_bit: Count(4, 65535, "Divisor of the UART: cycles per bit.")
    receive_buffer: PowerOfTwo(8, 1 << 15, "Bytes of received bodies that the chip can hold.")

    def interface(self):
        return {
            "rx": In(1, init=1),
            "tx": Out(1, init=1),
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

        m.submodules.uart_receiver = uart_receiver = UartReceiver(self.clocks_per_bit)
        m.submodules.uart_transmitter = uart_transmitter = UartTransmitter(self.clocks_per_bit)
        m.submodules.frame_receiver = frame_receiver = FrameReceiver(self.receive_buffer)
        m.submodules.frame_transmitter = frame_transmitter = FrameTransmitter()

        # Large units consume the requests and produce the replies; registers on both sides keep
        # their `valid` and `ready` off long combinational paths through the line.
        m.submodules.request_buffer = request_buffer = SkidBuffer(body_layout)
        m.submodules.request_register = request_register = StreamRegister(body_layout)
        m.submodules.reply_buffer = reply_buffer = SkidBuffer(body_layout)
        m.submodules.reply_register = reply_register = StreamRegister(body_layout)

        m.d.comb += [
            uart_receiver.rx.eq(self.rx),
            self.tx.eq(uart_transmitter.tx),
            self.busy.eq(frame_receiver.line_busy),
            self.sending.eq(uart_transmitter.bytes.valid | ~uart_transmitter.bytes.ready),
            self.errors.eq(
                Cat(
                    uart_receiver.framing_error,
                    frame_receiver.overrun,
                    frame_receiver.crc_error,
                    frame_receiver.malformed,
                )
            ),
        ]
        connect(m, uart_receiver.bytes, frame_receiver.bytes)
        connect(m, frame_receiver.requests, request_buffer.words)
        connect(m, request_buffer.passed, request_register.words)
        connect(m, request_register.passed, flipped(self.requests))
        connect(m, flipped(self.replies), reply_buffer.words)
        connect(m, reply_buffer.passed, reply_register.words)
        connect(m, reply_register.passed, frame_transmitter.replies)
        connect(m, frame_transmitter.bytes, uart_transmitter.bytes)

        with m.If(uart_receiver.bytes.valid):
            m.d.sync += self.bytes_received.eq(self.bytes_received + 1)
        with m.If(uart_transmitter.bytes.valid & uart_transmitter.bytes.ready):
            m.d.sync += self.bytes_sent.eq(self.bytes_sent + 1)

        return m
