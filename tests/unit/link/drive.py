"""Drivers of streams for the Amaranth simulator."""

import itertools

from tests.streams import simulate


__all__ = ["drive", "pass_through", "watch"]


async def drive(ctx, stream, words, pauses=(0,), limit=100_000):
    """Offer ``words`` one by one, after as many idle cycles as the next of ``pauses`` says."""
    for word, pause in zip(words, itertools.cycle(pauses), strict=False):
        if pause:
            await ctx.tick().repeat(pause)
        ctx.set(stream.payload, word)
        ctx.set(stream.valid, 1)
        for _ in range(limit):
            *_, ready = await ctx.tick().sample(stream.ready)
            if ready:
                break
        else:
            raise AssertionError(f"{word!r} was not taken within {limit} cycles")
        ctx.set(stream.valid, 0)


def watch(stream, words, pauses=(0,)):
    """Return a background process that takes every word into the list ``words``.

    It checks that an offer stays until it is taken. The word is appended with the number of the
    cycle that took it.
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
    """Send ``words`` through a register of a stream; return each with the cycle that took it."""
    passed = []

    async def feed(ctx):
        await drive(ctx, dut.words, words, drive_pauses)
        await ctx.tick().repeat(6)

    simulate(dut, feed, background=[watch(dut.passed, passed, watch_pauses)])
    return passed
