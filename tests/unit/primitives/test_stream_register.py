# amaranth: UnusedElaboratable=no
"""The stream register: every word once and in order, a cycle later, at full rate."""

import pytest

from pathgene.hdl.primitives.buffers import StreamRegister
from tests.support.gateware.streams import simulate
from tests.unit.link.drive import pass_through


WORDS = list(range(40))


@pytest.mark.parametrize("drive_pauses", [(0,), (0, 0, 1), (3, 0, 2, 0)])
@pytest.mark.parametrize("watch_pauses", [(0,), (1,), (0, 0, 4, 0, 1)])
def test_every_word_passes_once_and_in_order(drive_pauses, watch_pauses):
    passed = pass_through(StreamRegister(8), WORDS, drive_pauses, watch_pauses)
    assert [word for _, word in passed] == WORDS
    if watch_pauses == (0,) == drive_pauses:
        assert [cycle for cycle, _ in passed] == [cycle + 1 for cycle in WORDS]


def test_an_offer_does_not_depend_on_its_predecessor():
    dut = StreamRegister(8)

    async def bench(ctx):
        ctx.set(dut.words.valid, 1)
        ctx.set(dut.words.payload, 1)
        assert not ctx.get(dut.passed.valid)
        await ctx.tick()
        ctx.set(dut.words.valid, 0)
        ctx.set(dut.words.payload, 2)
        assert (ctx.get(dut.passed.valid), ctx.get(dut.passed.payload)) == (1, 1)

    simulate(dut, bench)
