"""The selection unit compared with the model, cycle by cycle."""

import dataclasses
import random

import pytest
from amaranth.hdl import Fragment

from pathgene.hdl.config import CheckerBuild, Config, SurvivorSelection
from pathgene.hdl.ga_core.selection import Selection
from pathgene.hdl.protocol.random_words import WARM_UP_STEPS
from pathgene.sim.model import selection as model
from pathgene.sim.model.random_source import RandomSource
from tests.support.gateware.chips import TINY
from tests.support.gateware.streams import pulse, resettable, shared, simulate


# Each has the latency of its unit.
CASES = {
    "default": (Config(checker=CheckerBuild.NONE), 15),
    "by_rank": (Config(survivor_selection=SurvivorSelection.RANK, checker=CheckerBuild.NONE), 15),
    "small": (TINY, 10),
    "small_by_rank": (TINY.replace(survivor_selection=SurvivorSelection.RANK), 10),
    "one_survivor": (TINY.replace(children=6, elites=1, survivors=1, deletes=4), 13),
    "many_survivors": (Config(survivors=20, children=8, elites=4, checker=CheckerBuild.NONE), 27),
    "many_mutators": (Config(perturbs=3, inserts=10, deletes=9, checker=CheckerBuild.NONE), 39),
    "with_map": (Config(checker=CheckerBuild.PARALLEL), 18),
    "most_redraws": (TINY.replace(checker=CheckerBuild.PARALLEL, redraws=7), 23),
    "largest": (
        Config(population=256, children=100, elites=148, map_size=4096, checker=CheckerBuild.NONE),
        53,
    ),
}
EACH_CASE = pytest.mark.parametrize(("config", "latency"), CASES.values(), ids=CASES)


def outputs(ctx, dut):
    """Return the current set in the form of the model's draws."""
    return model.Draws(
        tuple(ctx.get(dut.parents)),
        tuple(ctx.get(dut.survivors)),
        tuple(ctx.get(dut.children)),
        tuple(ctx.get(dut.waypoints)),
        tuple((offset.x, offset.y, offset.altitude) for offset in ctx.get(dut.offsets)),
    )


def run(config, script):
    """Drive ``(seed or None, next)`` cycle by cycle; return the set of each cycle, or None."""
    dut = shared(Selection, config)
    seen = []

    async def testbench(ctx):
        for seed, following in script:
            ctx.set(dut.load, seed is not None)
            ctx.set(dut.seed, seed or 0)
            ctx.set(dut.next, following)
            seen.append(outputs(ctx, dut) if ctx.get(dut.ready) else None)
            await ctx.tick()

    simulate(dut, testbench)
    return seen


def predict(config, latency, script):
    """Return the expected result of :func:`run`."""
    unit = model.Selection(config)
    source, ready_at = RandomSource(0), WARM_UP_STEPS + latency - 1
    draws = unit.draw(source)
    expected = []
    for cycle, (seed, following) in enumerate(script):
        ready = cycle >= ready_at
        expected.append(draws if ready else None)
        if seed is not None:
            source, ready_at = RandomSource(seed), cycle + WARM_UP_STEPS + latency
            draws = unit.draw(source)
        elif following and ready:
            ready_at = cycle + latency
            draws = unit.draw(source)
    return expected


@EACH_CASE
def test_matches_model(config, latency):
    """Sets are used immediately or later, or requested too early; new seeds come at any time."""
    rng = random.Random(4)
    script = []
    for eager in (1.0, 0.05, 0.6):
        script += [(None, rng.random() < eager) for _ in range(WARM_UP_STEPS + 6 * latency)]
        for _ in range(10):
            # Loads fall on all phases of a warm-up and a set.
            script.append((rng.getrandbits(64), rng.random() < 0.5))
            pause = rng.randrange(WARM_UP_STEPS + 2 * latency)
            script += [(None, rng.random() < eager) for _ in range(pause)]
    seen = run(config, script)
    assert seen == predict(config, latency, script)
    assert len(set(seen)) > 20


@EACH_CASE
def test_latency(config, latency):
    first = WARM_UP_STEPS + latency - 1
    script = [(None, 0)] * first + [(None, 1)] + [(None, 0)] * latency
    ready = [draws is not None for draws in run(config, script)]
    assert ready == [False] * first + [True] + [False] * (latency - 1) + [True]
    dut = shared(Selection, config)
    Fragment.get(dut, None)
    assert dut.latency == latency


def test_default_set_is_ready_before_a_full_generation_ends():
    config, latency = CASES["default"]
    assert latency <= config.max_waypoints


def test_offsets_are_taken():
    """All or some are taken, with or without pauses; the next set is complete again."""
    config = TINY.replace(checker=CheckerBuild.PARALLEL, inserts=2, deletes=1, redraws=3)
    dut = shared(Selection, config)
    rng = random.Random(5)
    unit, source = model.Selection(config), RandomSource(0)

    async def testbench(ctx):
        for pause in (0, 0, 0.5, 0.5, 0.9):
            while not ctx.get(dut.ready):
                await ctx.tick()
            expected = unit.draw(source)
            assert outputs(ctx, dut) == expected
            left = list(expected.offsets)
            for _ in range(rng.randint(1, len(left))):
                while rng.random() < pause:
                    await ctx.tick()
                offset = ctx.get(dut.offsets)[0]
                assert (offset.x, offset.y, offset.altitude) == left.pop(0)
                await pulse(ctx, dut.offset_taken)
                drawn = outputs(ctx, dut)
                assert list(drawn.offsets[: len(left)]) == left
                assert dataclasses.replace(drawn, offsets=expected.offsets) == expected
            await pulse(ctx, dut.next)

    simulate(dut, testbench)


def test_offsets_reach_the_whole_box():
    config = TINY.replace(box_percent=100, inserts=2)
    seen = run(config, [(None, 1)] * 1500)
    offsets = [offset for draws in seen if draws is not None for offset in draws.offsets]
    for steps in zip(*offsets, strict=True):
        assert set(steps) == set(range(-8, 9))


def test_reset_in_every_cycle_of_a_set():
    """Draws in flight do not enter the first set after the reset."""
    config, latency = CASES["small"]
    unit = model.Selection(config)
    expected = unit.draw(RandomSource(0))
    dut = shared(Selection, config)
    top, rst = resettable(dut)

    async def testbench(ctx):
        for wait in range(latency + 2):
            for _ in range(WARM_UP_STEPS + latency - 1):
                await ctx.tick()
            assert outputs(ctx, dut) == expected
            await pulse(ctx, dut.next)
            for _ in range(wait):
                await ctx.tick()
            await pulse(ctx, rst)
            assert not ctx.get(dut.ready)
        for _ in range(WARM_UP_STEPS + latency - 1):
            assert not ctx.get(dut.ready)
            await ctx.tick()
        assert ctx.get(dut.ready)
        assert outputs(ctx, dut) == expected

    simulate(top, testbench)
