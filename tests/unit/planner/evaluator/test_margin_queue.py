"""The queue of margins: none is lost, as slowly as they may be taken."""

from bisect import bisect

from hdl.planner.evaluator.margin_queue import MarginQueue
from tests.streams import simulate


def run(dut, count, comes, takes):
    """Return margins, and when each comes and goes; whether each cycle moves one is a function."""
    margins, came, went = [], [], []

    async def bench(ctx):
        cycle = 0
        while len(margins) < count:
            number = len(came)
            put = number < count and comes(cycle)
            ctx.set(dut.slot, number % 5)
            ctx.set(dut.margin, {"valid": put, "index": number % 4, "margin": number % 30 - 15})
            ctx.set(dut.margins.ready, takes(cycle))
            assert ctx.get(dut.idle) == (len(came) == len(margins))
            if ctx.get(dut.margins.valid & dut.margins.ready):
                each = ctx.get(dut.margins.p)
                margins.append((each.place.slot, each.place.index, each.margin))
                went.append(cycle)
            if put:
                came.append(cycle)
            await ctx.tick()
            cycle += 1
            assert cycle < 10_000

    simulate(dut, bench)
    assert margins == [(i % 5, i % 4, i % 30 - 15) for i in range(count)]
    return came, went


def test_a_margin_is_offered_3_cycles_later():
    came, went = run(MarginQueue(5, 4, 4), 20, lambda cycle: cycle % 7 in (1, 5), lambda _: True)
    assert went == [cycle + 3 for cycle in came]


def test_as_many_margins_as_may_wait():
    """With all margins of 16 paths and one in every other cycle, while as many are taken, late."""
    dut = MarginQueue(5, 11, 4)
    came, went = run(
        dut,
        900,
        lambda cycle: cycle < 2 * 16 * dut.max_waypoints or cycle % 2,
        lambda cycle: cycle >= 2 * 64 and cycle % 2,
    )
    waiting = [bisect(came, cycle) - number for number, cycle in enumerate(went)]
    # One more while a cycle without ``ready`` comes first.
    assert max(waiting) == 16 * dut.max_waypoints + 64 + 1 < dut.depth == 256
