"""The pool of slots: it hands out free slots, and loses none."""

import random

import pytest

from pathgene.hdl.planner.slot_pool import SlotPool
from tests.support.gateware.streams import simulate


@pytest.mark.parametrize(("total", "depth"), [(2, 1), (12, 4), (150, 22)])
def test_random_traffic(total, depth):
    """Each slot handed out is free; unused slots come first, then returned ones, in order."""
    dut = SlotPool(total, depth)
    rng = random.Random(total)

    async def bench(ctx):
        for _ in range(3):
            used, back, unused = [], [], 0
            offered = None
            for _ in range(60 + 5 * total):
                ready = rng.random() < 0.6
                puts = bool(used) and len(back) < depth and rng.random() < 0.3
                slot = used.pop(rng.randrange(len(used))) if puts else 0
                ctx.set(dut.slots.ready, ready)
                ctx.set(dut.put, puts)
                ctx.set(dut.slot, slot)
                valid, given = ctx.get(dut.slots.valid), ctx.get(dut.slots.payload)
                assert valid == (offered is not None)
                if valid:
                    assert given == offered
                    if ready:
                        used.append(offered)
                        offered = None
                else:
                    if unused < total:
                        offered, unused = unused, unused + 1
                    elif back:
                        offered = back.pop(0)
                if puts:
                    back.append(slot)
                await ctx.tick()
            assert unused == total
            ctx.set(dut.put, 0)
            ctx.set(dut.clear, 1)
            await ctx.tick()
            ctx.set(dut.clear, 0)

    simulate(dut, bench)
