"""UART on a line with a different clock."""

import itertools
import math

import pytest

from pathgene.hdl.link.uart import Uart, UartReceiver, UartTransmitter
from tests.support.gateware.streams import drive, shared, simulate, watch


# Every pair of successive bits, single bits, and the extremes.
BYTES = [0x00, 0xFF, 0x55, 0xAA, 0x01, 0x80, 0xFE, 0x7F, 0x0F, 0xC3]


def levels(values, clocks_per_bit, phase=0.0):
    """Return the line at each clock edge; bits may last fractions of a cycle or begin late."""
    bits = [bit for value in values for bit in (0, *((value >> i) & 1 for i in range(8)), 1)]
    edges = range(math.ceil(len(bits) * clocks_per_bit + phase))
    return [bits[max(-1, math.floor((edge - phase) / clocks_per_bit))] for edge in edges]


def receive(clocks_per_bit, line):
    """Return bytes with the cycles in which they are offered, and cycles of framing errors."""
    dut = shared(UartReceiver, clocks_per_bit)
    received, errors = [], []

    async def send(ctx):
        for level, cycles in itertools.groupby([*line, *[1] * (2 * clocks_per_bit + 8)]):
            ctx.set(dut.rx, level)
            await ctx.tick().repeat(len(list(cycles)))

    async def collect(ctx):
        ctx.set(dut.bytes.ready, 1)
        cycle = 0
        signals = (dut.bytes.valid, dut.bytes.payload, dut.framing_error)
        async for *_, valid, value, error in ctx.tick().sample(*signals):
            if valid:
                received.append((cycle, value))
            if error:
                errors.append(cycle)
            cycle += 1

    simulate(dut, send, background=[collect])
    return received, errors


def values(received):
    return [value for _, value in received]


@pytest.mark.parametrize("mismatch", [-0.02, 0.0, 0.02], ids=["fast", "equal", "slow"])
@pytest.mark.parametrize("clocks_per_bit", [4, 5, 6, 7, 16, 33])
def test_receives_without_pauses(clocks_per_bit, mismatch):
    for phase in (0.0, 0.3, 0.6, 0.9) if clocks_per_bit < 8 else (0.0,):
        line = levels(BYTES, clocks_per_bit * (1 + mismatch), phase)
        received, errors = receive(clocks_per_bit, line)
        assert values(received) == BYTES, phase
        assert errors == []


def test_receives_at_nearly_five_percent_with_a_large_divisor():
    for mismatch in (-0.045, 0.045):
        received, errors = receive(64, levels(BYTES[2:5], 64 * (1 + mismatch)))
        assert values(received) == BYTES[2:5]
        assert errors == []


@pytest.mark.parametrize("clocks_per_bit", [4, 5, 33])
def test_offers_a_byte_in_the_documented_cycle(clocks_per_bit):
    idle = 5
    received, _ = receive(clocks_per_bit, [1] * idle + levels([0xA5], clocks_per_bit))
    assert received == [(idle + 9 * clocks_per_bit + (clocks_per_bit - 1) // 2 + 4, 0xA5)]


def test_keeps_a_byte_until_the_next_is_complete():
    dut = shared(UartReceiver, 4)
    taken = []

    async def send(ctx):
        for level in levels([1, 2, 3], 4) + [1] * 20:
            ctx.set(dut.rx, level)
            await ctx.tick()
        taken.append((ctx.get(dut.bytes.valid), ctx.get(dut.bytes.payload)))
        ctx.set(dut.bytes.ready, 1)
        await ctx.tick()
        taken.append(ctx.get(dut.bytes.valid))

    simulate(dut, send)
    assert taken == [(1, 3), 0]


@pytest.mark.parametrize("clocks_per_bit", [6, 16])
def test_ignores_spikes_of_one_cycle(clocks_per_bit):
    line = levels(BYTES, clocks_per_bit)
    # Every bit has a spike, in each of its cycles in turn except those at its edges.
    for bit in range(len(line) // clocks_per_bit):
        line[bit * clocks_per_bit + 2 + bit % (clocks_per_bit - 4)] ^= 1
    received, errors = receive(clocks_per_bit, [1, 1, 0, 1, 1, 1, *line])
    assert values(received) == BYTES
    assert errors == []


def test_ignores_a_start_bit_that_ends_before_its_middle():
    received, errors = receive(33, [1] * 4 + [0] * 15 + [1] * 60 + levels([0x42], 33))
    assert values(received) == [0x42]
    assert errors == []


def test_a_low_stop_bit_is_one_error_and_no_byte():
    broken = [0] * 4 + [1] * 32 + [0] * 4
    received, errors = receive(4, levels([7], 4) + broken + [1] * 4 + levels([9], 4))
    assert values(received) == [7, 9]
    assert len(errors) == 1


def test_a_long_break_is_one_error():
    received, errors = receive(4, levels([7], 4) + [0] * 1000 + [1] * 4 + levels([9], 4))
    assert values(received) == [7, 9]
    assert len(errors) == 1


def test_synchronizes_after_an_idle_byte():
    # The receiver starts in the middle of a byte; after one idle byte it is synchronized.
    line = levels([0x00, 0x5A, 0xFF], 8)
    for skipped in range(0, 80, 5):
        received, _ = receive(8, line[skipped:] + [1] * 80 + levels(BYTES, 8))
        assert values(received)[-len(BYTES) :] == BYTES, skipped


@pytest.mark.parametrize("clocks_per_bit", [4, 5, 33])
def test_transmits_without_idle_cycles(clocks_per_bit):
    dut = shared(UartTransmitter, clocks_per_bit)
    line = []

    async def send(ctx):
        await drive(ctx, dut.bytes, BYTES)
        await ctx.tick().repeat(10 * clocks_per_bit + 5)

    async def sample(ctx):
        while True:
            *_, level = await ctx.tick().sample(dut.tx)
            line.append(level)

    simulate(dut, send, background=[sample])
    # The first byte is accepted in cycle 0, and its start bit begins 1 cycle later.
    assert line == [1] + levels(BYTES, clocks_per_bit) + [1] * 5


def test_transmits_at_once_after_a_pause():
    dut = shared(UartTransmitter, 4)
    line = []

    async def send(ctx):
        await drive(ctx, dut.bytes, [0x00])
        await ctx.tick().repeat(57)
        await drive(ctx, dut.bytes, [0x00])
        await ctx.tick().repeat(45)

    async def sample(ctx):
        while True:
            *_, level = await ctx.tick().sample(dut.tx)
            line.append(level)

    simulate(dut, send, background=[sample])
    assert line == [1] + levels([0], 4) + [1] * 18 + levels([0], 4) + [1] * 5


def test_both_directions_of_one_uart():
    dut = shared(Uart, 4)
    received = []

    async def loop(ctx):
        while True:
            *_, level = await ctx.tick().sample(dut.tx)
            ctx.set(dut.rx, level)

    async def send(ctx):
        await drive(ctx, dut.sent, BYTES, pauses=(0, 0, 13))
        await ctx.tick().repeat(50)

    simulate(dut, send, background=[loop, watch(dut.received, received)])
    assert values(received) == BYTES
