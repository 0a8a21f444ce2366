"""The exported UART on a line whose bit times differ from the UART's.

CLOCKS_PER_BIT in the environment is the divisor; streams are shorter with large divisors.
"""

import os
import random

import cocotb
import cocotb.simtime
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge, Timer, with_timeout

from pathgene.hdl.config import Config


TOP = "uart"
CONFIG = Config(clocks_per_bit=int(os.environ.get("CLOCKS_PER_BIT", "33")))

CLOCK_PS = 10_000
BIT_PS = CLOCK_PS * CONFIG.clocks_per_bit
# A similar simulated time for every divisor.
COUNT = min(100, 1000 // CONFIG.clocks_per_bit)


class Bench:
    """A clock, the bytes received, and a line in each direction."""

    def __init__(self, dut):
        self.dut = dut
        self.received = []
        self.framing_errors = 0
        dut.rst.value = 0
        dut.rx.value = 1
        dut.sent__valid.value = 0
        dut.received__ready.value = 1
        Clock(dut.clk, CLOCK_PS, unit="ps").start()
        cocotb.start_soon(self._collect())
        cocotb.start_soon(self._count_errors())

    async def _collect(self):
        while True:
            await RisingEdge(self.dut.received__valid)
            await FallingEdge(self.dut.clk)
            self.received.append(self.dut.received__payload.value.to_unsigned())

    async def _count_errors(self):
        while True:
            await RisingEdge(self.dut.framing_error)
            self.framing_errors += 1

    async def send(self, values, bit_ps=BIT_PS):
        """Drive ``rx``: start bit, eight bits, stop bit, without a pause."""
        for value in values:
            for level in (0, *((value >> bit) & 1 for bit in range(8)), 1):
                self.dut.rx.value = level
                await Timer(round(bit_ps), "ps")

    async def give(self, values):
        """Offer bytes to the transmitter, each as soon as its predecessor is accepted."""
        self.dut.sent__valid.value = 1
        for value in values:
            self.dut.sent__payload.value = value
            # Ready until the clock edge that accepts the byte.
            await FallingEdge(self.dut.sent__ready)
        self.dut.sent__valid.value = 0

    async def read_line(self, count):
        """Read ``count`` bytes from ``tx`` at the nominal bit time."""
        values = []
        for _ in range(count):
            if self.dut.tx.value:
                await FallingEdge(self.dut.tx)
            await Timer(BIT_PS // 2, "ps")
            assert self.dut.tx.value == 0
            value = 0
            for bit in range(8):
                await Timer(BIT_PS, "ps")
                value |= int(self.dut.tx.value) << bit
            await Timer(BIT_PS, "ps")
            assert self.dut.tx.value == 1
            values.append(value)
        return values


def random_bytes(seed):
    return [*random.Random(seed).randbytes(COUNT), 0x00, 0xFF, 0x00, 0x55]


@cocotb.test()
@cocotb.parametrize(mismatch_percent=[-2.0, 0.0, 2.0])
async def receives_at_full_rate(dut, mismatch_percent):
    """Receive bytes without pauses from a slow, an exact and a fast sender."""
    bench = Bench(dut)
    values = random_bytes(1)
    await Timer(3 * CLOCK_PS + 1234, "ps")
    await bench.send(values, BIT_PS * (1 + mismatch_percent / 100))
    await Timer(BIT_PS, "ps")
    assert bench.received == values
    assert bench.framing_errors == 0


@cocotb.test()
async def receives_after_a_break_and_noise(dut):
    """Count a break as one error and ignore a spike; receive the bytes after them."""
    bench = Bench(dut)
    await Timer(3 * CLOCK_PS, "ps")
    await bench.send([0x42])
    dut.rx.value = 0
    await Timer(25 * BIT_PS, "ps")
    dut.rx.value = 1
    await Timer(BIT_PS, "ps")
    dut.rx.value = 0
    await Timer(CLOCK_PS // 2, "ps")
    dut.rx.value = 1
    await Timer(BIT_PS, "ps")
    await bench.send([0x24, 0x81])
    await Timer(BIT_PS, "ps")
    assert bench.received == [0x42, 0x24, 0x81]
    assert bench.framing_errors == 1


@cocotb.test()
async def transmits_at_full_rate(dut):
    """Transmit without pauses: a byte every ten bits."""
    bench = Bench(dut)
    values = random_bytes(2)
    giving = cocotb.start_soon(bench.give(values))
    await FallingEdge(dut.tx)
    start = cocotb.simtime.get_sim_time("ps")
    reading = cocotb.start_soon(bench.read_line(len(values)))
    limit = 11 * BIT_PS * len(values)
    assert await with_timeout(reading, limit, "ps") == values
    await giving
    # The last stop bit was sampled in its middle, half a bit before its end.
    elapsed = cocotb.simtime.get_sim_time("ps") - start
    assert abs(elapsed - BIT_PS * (10 * len(values) - 0.5)) <= 2 * CLOCK_PS


@cocotb.test()
async def both_directions_at_once(dut):
    """Receive and transmit at the same time."""
    bench = Bench(dut)
    await Timer(3 * CLOCK_PS, "ps")
    values, answers = random_bytes(3), random_bytes(4)
    sending = cocotb.start_soon(bench.send(values))
    giving = cocotb.start_soon(bench.give(answers))
    limit = 11 * BIT_PS * len(answers)
    assert await with_timeout(bench.read_line(len(answers)), limit, "ps") == answers
    await sending
    await giving
    await Timer(BIT_PS, "ps")
    assert bench.received == values
