"""The gateware of the random source, compared with the model."""

import random

import pytest

from pathgene.hdl.ga_core.random_source import RandomSource, Trivium
from pathgene.hdl.protocol.random_words import LANES, WARM_UP_STEPS
from pathgene.sim.model import random_source as model
from tests.support.gateware.streams import pulse, shared, simulate


def run(script):
    """Drive ``(seed or None, step)`` cycle by cycle; return ``(ready, words)`` in each cycle."""
    dut = shared(RandomSource)
    seen = []

    async def testbench(ctx):
        for seed, step in script:
            ctx.set(dut.load, seed is not None)
            ctx.set(dut.seed, seed or 0)
            ctx.set(dut.step, step)
            seen.append((ctx.get(dut.ready), tuple(ctx.get(dut.words))))
            await ctx.tick()

    simulate(dut, testbench)
    return seen


def words(seed, steps):
    source = model.RandomSource(seed)
    return [source.step() for _ in range(steps)]


WARM_UP = [(None, 0)] * WARM_UP_STEPS


@pytest.mark.parametrize("seed", [0, 1, 1 << 63, (1 << 64) - 1, 0x0123456789ABCDEF])
def test_matches_model(seed):
    seen = run([(seed, 0), *WARM_UP, *[(None, 1)] * 40])
    assert seen[1 + WARM_UP_STEPS :] == [(1, step) for step in words(seed, 40)]


def test_is_seeded_with_0_after_reset():
    seen = run([*WARM_UP, (None, 1), (None, 1)])
    assert [ready for ready, _ in seen] == [0] * WARM_UP_STEPS + [1, 1]
    assert [step for _, step in seen[WARM_UP_STEPS:]] == words(0, 2)


def test_is_ready_one_cycle_after_the_warm_up():
    seen = run([*WARM_UP, (5, 0), *WARM_UP, (None, 0)])
    assert [ready for ready, _ in seen[WARM_UP_STEPS:]] == [1] + [0] * WARM_UP_STEPS + [1]


def test_advances_with_step_alone():
    pauses = [(None, 1), (None, 0), (None, 0), (None, 1), (None, 0), (None, 1)]
    seen = run([(9, 0), *WARM_UP, *pauses])
    first, second, third = words(9, 3)
    assert [step for _, step in seen[1 + WARM_UP_STEPS :]] == [
        first, second, second, second, third, third
    ]  # fmt: skip


def test_ignores_steps_while_it_warms_up():
    seen = run([(9, 1), *[(None, 1)] * WARM_UP_STEPS, (None, 1)])
    assert seen[-1] == (1, words(9, 1)[0])


def test_every_cycle_of_a_random_script():
    """Loads come at any time, even during a warm-up or together with a step."""
    rng = random.Random(11)
    script, expected = [], []
    source, left = model.RandomSource(0), WARM_UP_STEPS
    present = source.step()
    for _ in range(2500):
        seed = rng.getrandbits(64) if rng.random() < 0.03 else None
        step = rng.random() < 0.6
        script.append((seed, step))
        expected.append((left == 0, present if left == 0 else None))
        if seed is not None:
            source, left = model.RandomSource(seed), WARM_UP_STEPS
            present = source.step()
        elif left:
            left -= 1
        elif step:
            present = source.step()

    seen = [(ready, step if ready else None) for ready, step in run(script)]
    assert sum(ready for ready, _ in seen) > 1000
    assert seen == expected


def test_lane_takes_its_iv():
    dut = shared(Trivium, iv=0xFEDCBA98765432100123)
    expected = model.Trivium(3, 0xFEDCBA98765432100123)

    async def testbench(ctx):
        ctx.set(dut.key, 3)
        await pulse(ctx, dut.load)
        ctx.set(dut.step, 1)
        await ctx.tick().repeat(WARM_UP_STEPS)
        for _ in range(20):
            assert ctx.get(dut.word) == expected.step()
            await ctx.tick()

    simulate(dut, testbench)


def test_lanes_differ():
    seen = run([*WARM_UP, (None, 0)])
    assert len(set(seen[-1][1])) == LANES
