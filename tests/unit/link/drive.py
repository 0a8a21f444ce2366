"""Drivers of streams for the Amaranth simulator."""

import itertools

from tests.support.gateware.streams import put, simulate


__all__ = ["drive", "pass_through", "watch"]


async def drive(ctx, stream, words, pauses=(0,), limit=100_000):
    """Offer ``words`` one by one, each after the next of ``pauses`` in idle cycles."""
    for word, pause in zip(words, itertools.cycle(pauses), strict=False):
        if pause:
            await ctx.tick().repeat(pause)
        await put(ctx, stream, word, limit)


def watch(stream, words, pauses=(0,)):
    """Return a background process that appends every word to ``words``, with its cycle.

    It checks that an offer stays until it is accepted.
    """

    async def process(ctx):
        pause = itertools.cycle(pauses)
        left = next(pause)
        offered = None
        cycle = 0
        while True:
            ctx.set(stream.ready, left == 0)
            *_, valid, word = await ctx.tick().sample(stream.valid, stream.payload)
            assert offered is None or (valid and word == offered), "an offer was taken back"
            offered = word if valid and left else None
            if valid and left == 0:
                words.append((cycle, word))
                left = next(pause)
            elif left:
                left -= 1
            cycle += 1

    return process


def pass_through(dut, words, drive_pauses, watch_pauses):
    """Send ``words`` through a unit with one stream in and out; return each with its cycle."""
    passed = []

    async def feed(ctx):
        await drive(ctx, dut.words, words, drive_pauses)
        await ctx.tick().repeat(6)

    simulate(dut, feed, background=[watch(dut.passed, passed, watch_pauses)])
    return passed
