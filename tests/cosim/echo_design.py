"""Small chips for the tests of the simulators: a UART and a byte-wide port that echo."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out

from pathgene.hdl.verilog import convert


class UartEcho(wiring.Component):
    """UART that sends back every received byte plus ``offset``.

    A frame starts 2 to 3 cycles after the middle of the stop bit of its byte. Receiver and sender
    run at the same rate, so the buffer only bridges the length of a stop bit.

    Parameters
    ----------
    clocks_per_bit : int
        Divisor of the UART, 2 or more.
    offset : int
        Added to each byte, modulo 256.
    bad_stop : bool
        Whether stop bits are low, for tests of the detection of faulty chips.
    """

    rx: In(1, init=1)
    tx: Out(1, init=1)

    def __init__(self, clocks_per_bit, *, offset=0, bad_stop=False):
        self.clocks_per_bit = clocks_per_bit
        self.offset = offset
        self.bad_stop = bad_stop
        super().__init__()

    def elaborate(self, platform):
        m = Module()

        m.submodules.bytes = fifo = SyncFIFOBuffered(width=8, depth=16)

        line = Signal(2, init=0b11)
        m.d.sync += line.eq(Cat(self.rx, line[0]))

        rx_wait = Signal(range(2 * self.clocks_per_bit))
        rx_left = Signal(range(11))
        rx_bits = Signal(9)
        with m.If(rx_left == 0):
            with m.If(~line[1]):
                m.d.sync += [rx_left.eq(10), rx_wait.eq(self.clocks_per_bit // 2 - 1)]
        with m.Elif(rx_wait != 0):
            m.d.sync += rx_wait.eq(rx_wait - 1)
        with m.Else():
            m.d.sync += [
                rx_wait.eq(self.clocks_per_bit - 1),
                rx_left.eq(rx_left - 1),
                rx_bits.eq(Cat(rx_bits[1:], line[1])),
            ]
        m.d.comb += [
            fifo.w_data.eq(rx_bits[1:]),
            fifo.w_en.eq((rx_left == 1) & (rx_wait == 0)),
        ]

        tx_wait = Signal(range(self.clocks_per_bit))
        tx_left = Signal(range(11))
        tx_bits = Signal(10, init=0x3FF)
        stop = 0 if self.bad_stop else 1
        with m.If(tx_wait != 0):
            m.d.sync += tx_wait.eq(tx_wait - 1)
        with m.Elif(tx_left > 1):
            m.d.sync += [
                tx_left.eq(tx_left - 1),
                tx_wait.eq(self.clocks_per_bit - 1),
                tx_bits.eq(Cat(tx_bits[1:], C(1))),
            ]
        with m.Elif(fifo.r_rdy):
            m.d.comb += fifo.r_en.eq(1)
            m.d.sync += [
                tx_left.eq(10),
                tx_wait.eq(self.clocks_per_bit - 1),
                tx_bits.eq(Cat(C(0), (fifo.r_data + self.offset)[:8], C(stop))),
            ]
        with m.Else():
            m.d.sync += [tx_left.eq(0), tx_bits.eq(0x3FF)]
        m.d.comb += self.tx.eq(tx_bits[0])

        return m


class ByteEcho(wiring.Component):
    """Byte-wide port that sends back every received byte plus ``offset``.

    It takes no byte in one of four cycles, so a board that ignores ``rx_ready`` loses bytes.
    """

    rx_data: In(8)
    rx_valid: In(1)
    rx_ready: Out(1)
    tx_data: Out(8)
    tx_valid: Out(1)
    tx_ready: In(1)

    def __init__(self, *, offset=0):
        self.offset = offset
        super().__init__()

    def elaborate(self, platform):
        m = Module()

        m.submodules.bytes = fifo = SyncFIFOBuffered(width=8, depth=16)
        phase = Signal(2)
        m.d.sync += phase.eq(phase + 1)
        m.d.comb += [
            self.rx_ready.eq((phase != 0) & fifo.w_rdy),
            fifo.w_data.eq(self.rx_data),
            fifo.w_en.eq(self.rx_valid & self.rx_ready),
            self.tx_valid.eq(fifo.r_rdy),
            self.tx_data.eq(fifo.r_data + self.offset),
            fifo.r_en.eq(self.tx_ready),
        ]

        return m


def byte_echo_verilog(**options):
    """Return the Verilog of a :class:`ByteEcho`, module ``byte_echo``."""
    return convert(ByteEcho(**options), "byte_echo")


def echo_verilog(clocks_per_bit=4, **options):
    """Return the Verilog of a :class:`UartEcho`, module ``uart_echo``."""
    return convert(UartEcho(clocks_per_bit, **options), "uart_echo")
