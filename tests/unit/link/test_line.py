"""The line counts bytes in both directions and raises `sending` during a reply."""

import pytest

from pathgene.hdl.link.line import Line
from pathgene.hdl.protocol.codec import encode_frame
from pathgene.hdl.protocol.codes import StickyError
from tests.support.gateware.chips import SMALL
from tests.support.gateware.streams import collect, drive, put, shared, simulate


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


@pytest.mark.parametrize("pauses", [(0,), (3, 0, 0, 7)])
def test_a_byte_wide_port_carries_the_same_frames(pauses):
    dut = shared(Line, 0, SMALL.receive_buffer)
    bodies = [b"\x01\x02\x03", b"\x00\x00\x00\xff", bytes(range(200))]
    sent = b"".join(encode_frame(body, plain=False) for body in bodies)
    requests, replies, errors, sending = [], [], [], []

    async def bench(ctx):
        await drive(ctx, dut.received, [*sent, 0x01, 0x00], pauses)
        await ctx.tick().repeat(600)
        assert ctx.get(dut.bytes_received) == len(sent) + 2
        for body in bodies:
            for place, byte in enumerate(body):
                last = place == len(body) - 1
                await put(ctx, dut.replies, {"data": byte, "last": last, "plain": 0})
        await ctx.tick().repeat(2000)
        assert ctx.get(dut.bytes_sent) == len(sent)
        assert not ctx.get(dut.sending)

    async def watch(ctx):
        async for _, _, pulses, busy, valid in ctx.tick().sample(
            dut.errors, dut.sending, dut.sent.valid
        ):
            errors.extend([StickyError(int(pulses))] if pulses else [])
            sending.append(busy == valid)

    background = [collect(dut.requests, requests), collect(dut.sent, replies, pauses), watch]
    simulate(dut, bench, background=background)
    received = bytes(word["data"] for word in requests)
    assert received == b"".join(bodies)
    assert [place for place, word in enumerate(requests) if word["last"]] == [2, 6, 206]
    assert bytes(replies) == sent
    assert errors == [StickyError.MALFORMED]
    assert all(sending)
