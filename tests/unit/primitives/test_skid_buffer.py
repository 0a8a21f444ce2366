# amaranth: UnusedElaboratable=no
"""The skid buffer: every word once and in order, full rate, and a registered `ready`."""

import pytest

from pathgene.hdl.primitives.buffers import SkidBuffer
from tests.support.gateware.streams import simulate
from tests.unit.link.drive import pass_through


WORDS = list(range(40))


@pytest.mark.parametrize("drive_pauses", [(0,), (0, 0, 1), (3, 0, 2, 0)])
@pytest.mark.parametrize("watch_pauses", [(0,), (1,), (0, 0, 4, 0, 1)])
def test_every_word_passes_once_and_in_order(drive_pauses, watch_pauses):
    passed = pass_through(SkidBuffer(8), WORDS, drive_pauses, watch_pauses)
    assert [word for _, word in passed] == WORDS
    if watch_pauses == (0,) == drive_pauses:
        # Words pass in the cycles in which they are offered.
        assert [cycle for cycle, _ in passed] == WORDS


def test_ready_is_a_register():
    """`ready` follows the output's `ready` a cycle later, and the buffer holds a word."""
    dut = SkidBuffer(8)

    async def bench(ctx):
        ctx.set(dut.words.valid, 1)
        ctx.set(dut.words.payload, 1)
        for ready in (1, 0, 1, 0):
            ctx.set(dut.passed.ready, ready)
            assert ctx.get(dut.words.ready)
            assert (ctx.get(dut.passed.valid), ctx.get(dut.passed.payload)) == (1, 1)
        await ctx.tick()
        ctx.set(dut.words.payload, 2)
        for ready in (1, 0, 1):
            ctx.set(dut.passed.ready, ready)
            assert not ctx.get(dut.words.ready)
            assert (ctx.get(dut.passed.valid), ctx.get(dut.passed.payload)) == (1, 1)
        await ctx.tick()
        assert ctx.get(dut.words.ready)
        assert (ctx.get(dut.passed.valid), ctx.get(dut.passed.payload)) == (1, 2)

    simulate(dut, bench)
