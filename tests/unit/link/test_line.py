"""The line counts bytes in both directions and raises `sending` during a reply."""

from pathgene.hdl.link.line import Line
from pathgene.hdl.protocol.codes import StickyError
from tests.support.gateware.chips import SMALL
from tests.support.gateware.streams import put, shared, simulate


BIT = SMALL.clocks_per_bit


async def receive(ctx, dut, byte):
    """Send a byte to the pin, from the start bit to the stop bit."""
    for bit in (0, *(byte >> place & 1 for place in range(8)), 1):
        ctx.set(dut.rx, bit)
        await ctx.tick().repeat(BIT)


def test_counts_received_bytes():
    """Bytes of damaged frames count, too."""
    dut = shared(Line, SMALL.clocks_per_bit, SMALL.receive_buffer)
    counted = []

    async def bench(ctx):
        await ctx.tick().repeat(2 * BIT)
        for byte in (0x55, 0x00, 0xFF, 0x01):
            await receive(ctx, dut, byte)
            await ctx.tick().repeat(BIT)
            counted.append(ctx.get(dut.bytes_received))
        assert ctx.get(dut.bytes_sent) == 0

    simulate(dut, bench)
    assert counted == [1, 2, 3, 4]


def test_counts_sent_bytes_until_sending_ends():
    dut = shared(Line, SMALL.clocks_per_bit, SMALL.receive_buffer)
    pulses = []

    async def bench(ctx):
        assert not ctx.get(dut.sending)
        await put(ctx, dut.replies, {"data": 7, "last": 1, "plain": 0})
        for _ in range(40 * 10 * BIT):
            pulses.append(ctx.get(dut.sending))
            await ctx.tick()
            if pulses[-1] and not ctx.get(dut.sending):
                break
        # The byte with its CRC, the code byte of COBS and the delimiter.
        assert ctx.get(dut.bytes_sent) == 1 + 4 + 1 + 1
        assert ctx.get(dut.bytes_received) == 0

    simulate(dut, bench)
    assert sum(pulses) >= 7 * 10 * BIT


def test_a_frame_that_is_too_short_is_malformed():
    dut = shared(Line, SMALL.clocks_per_bit, SMALL.receive_buffer)
    errors = []

    async def bench(ctx):
        await ctx.tick().repeat(2 * BIT)
        for byte in (0x01, 0x00):
            await receive(ctx, dut, byte)
        await ctx.tick().repeat(20 * BIT)

    async def watch(ctx):
        async for _, _, pulses in ctx.tick().sample(dut.errors):
            if pulses:
                errors.append(StickyError(int(pulses)))

    simulate(dut, bench, background=[watch])
    assert errors == [StickyError.MALFORMED]
