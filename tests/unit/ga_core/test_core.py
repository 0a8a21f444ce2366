# amaranth: UnusedElaboratable=no
"""The whole core against the model: populations, slots, mutations and cycles.

``tests/cosim/cosim_core.py`` runs the paper's population, compiled.
"""

import random

import pytest
from amaranth.hdl import Value

from pathgene.hdl.config import SurvivorSelection
from pathgene.hdl.protocol import ChipState, Counter
from tests.support.gateware.chips import TINY
from tests.support.gateware.core_driver import Driver, fill, ranked_after, shuffled, simulate


CONFIGS = {
    "small": TINY,
    "shortest": TINY.replace(max_waypoints=3),
    "odd": TINY.replace(max_waypoints=5, survivors=1, elites=1, children=6, deletes=3, inserts=2),
    "longest": TINY.replace(max_waypoints=20, perturbs=2),
    "by_rank": TINY.replace(
        elites=1, survivors=3, box_percent=100, survivor_selection=SurvivorSelection.RANK
    ),
}


@pytest.mark.parametrize("name", CONFIGS)
def test_matches_model(name):
    """Random paths, then generations with reads, loads and new seeds in between."""
    config = CONFIGS[name]
    pauses = (0, 2, 0, 1) if name in ("odd", "by_rank") else (0,)

    async def bench(ctx, dut):
        rng = random.Random(name)
        driver = Driver(ctx, dut, rng, pauses)
        await driver.check_population()
        await fill(driver)
        for generation in range(12):
            await driver.generate(shuffled(rng, config))
            if generation % 4 == 0:
                await driver.check_population()
            if generation % 4 == 1:
                slot = rng.randrange(config.population)
                await driver.load(slot, driver.path())
            if generation % 4 == 2:
                slot = rng.randrange(config.population)
                count = rng.randint(1, config.population - slot)
                assert await driver.read(slot, count) == driver.model.paths[slot : slot + count]
            if generation % 6 == 5:
                await driver.start(rng.getrandbits(64))
        await driver.check_population()

    simulate(config, bench)


def test_longest_paths_take_four_cycles_more_than_waypoints():
    async def bench(ctx, dut):
        rng = random.Random(2)
        driver = Driver(ctx, dut, rng)
        await driver.start(1)
        await fill(driver, TINY.max_waypoints)
        for _ in range(3):
            await driver.generate(shuffled(rng, TINY))
            counters = ctx.get(dut.counters)
            assert counters[Counter.LONGEST] == TINY.max_waypoints + 4

    simulate(TINY, bench)


def test_refused_mutations_are_counted():
    async def bench(ctx, dut):
        rng = random.Random(3)
        driver = Driver(ctx, dut, rng)
        refused = 0
        for _ in range(6):
            done = await driver.generate(shuffled(rng, TINY))
            refused += sum(not mutated.applied for mutated in done.mutations)
        # All paths have two waypoints at first, so deletions are refused.
        assert refused > 1
        assert ctx.get(dut.counters)[Counter.REFUSED_MUTATIONS] == refused

    simulate(TINY, bench)


def test_cycles_of_a_ranking():
    async def bench(ctx, dut):
        driver = Driver(ctx, dut, random.Random(4))
        await driver.rank(range(TINY.population))
        assert await ranked_after(driver) == TINY.mutators + 13

    simulate(TINY, bench)


@pytest.mark.parametrize("event", ["start", "write", "rank", "generation"])
def test_ranking_is_discarded(event):
    async def bench(ctx, dut):
        rng = random.Random(5)
        driver = Driver(ctx, dut, rng)
        order = shuffled(rng, TINY)
        for wait in range(TINY.mutators + 16):
            await driver.rank(order)
            # The event comes while the ranking is processed, or later.
            for _ in range(wait):
                await driver.tick()
            match event:
                case "start":
                    await driver.start(wait)
                case "write":
                    await driver.load(1, driver.path())
                case "rank":
                    await driver.rank([3])
                case "generation":
                    await driver.generate(order)
            for _ in range(TINY.mutators + 16):
                assert not ctx.get(dut.ranked)
                await driver.tick()
        await driver.generate(order)
        await driver.check_population()

    simulate(TINY, bench)


def test_results_stay_until_the_next_generation():
    async def bench(ctx, dut):
        rng = random.Random(6)
        driver = Driver(ctx, dut, rng)

        def results():
            ports = (*dut.parents, *dut.survivors, *dut.mutations, *dut.patches)
            return [ctx.get(Value.cast(port)) for port in ports]

        await fill(driver)
        await driver.generate(shuffled(rng, TINY))
        before = results()
        await driver.rank(shuffled(rng, TINY))
        await ranked_after(driver)
        assert results() == before
        await driver.generate(shuffled(rng, TINY))
        assert results() != before

    simulate(TINY, bench)


def test_nothing_is_accepted_during_a_generation():
    async def bench(ctx, dut):
        driver = Driver(ctx, dut, random.Random(7))
        await driver.rank(range(TINY.population))
        await ranked_after(driver)
        for name in ("pending", "receive_done", "generate"):
            ctx.set(getattr(dut, name), 1)
        await driver.enter(ChipState.CROSSOVER)
        for flow in (dut.start_requests, dut.writes, dut.ranking, dut.reads):
            ctx.set(flow.valid, 1)
        while ctx.get(dut.state) != ChipState.TRANSMIT:
            for flow in (dut.start_requests, dut.writes, dut.ranking, dut.reads):
                assert not ctx.get(flow.ready)
            await driver.tick()
        assert ctx.get(dut.start_requests.ready)

    simulate(TINY, bench)
