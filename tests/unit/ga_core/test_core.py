"""The complete core compared with the model: populations, slots, mutations and cycles.

``tests/cosim/test_boards.py`` runs the paper's population, compiled. On a chip with a map, no new
waypoint lies in the ground.
"""

import random
from functools import partial

import pytest
from amaranth.hdl import Value

from pathgene.hdl.config import CheckerBuild, Config, MutationKind, SurvivorSelection
from pathgene.hdl.protocol.codes import ChipState, Counter
from pathgene.sim.model.mutation import Limits
from tests.support.gateware.chips import TINY
from tests.support.gateware.core_driver import Driver, fill, ranked_after, shuffled, simulate
from tests.support.gateware.streams import as_test


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
    """Generations from random paths match, with reads, loads and new seeds in between."""
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


@as_test(partial(simulate, TINY))
async def test_longest_paths_take_four_cycles_more_than_waypoints(ctx, dut):
    rng = random.Random(2)
    driver = Driver(ctx, dut, rng)
    await driver.start(1)
    await fill(driver, TINY.max_waypoints)
    for _ in range(3):
        await driver.generate(shuffled(rng, TINY))
        counters = ctx.get(dut.counters)
        assert counters[Counter.LONGEST] == TINY.max_waypoints + 4


@as_test(partial(simulate, TINY))
async def test_refused_mutations_are_counted(ctx, dut):
    rng = random.Random(3)
    driver = Driver(ctx, dut, rng)
    refused = 0
    for _ in range(6):
        done = await driver.generate(shuffled(rng, TINY))
        refused += sum(not mutated.applied for mutated in done.mutations)
    # All paths have two waypoints at first, so deletions are refused.
    assert refused > 1
    assert ctx.get(dut.counters)[Counter.REFUSED_MUTATIONS] == refused


@as_test(partial(simulate, TINY))
async def test_cycles_of_a_ranking(ctx, dut):
    driver = Driver(ctx, dut, random.Random(4))
    await driver.rank(range(TINY.population))
    assert await ranked_after(driver) == TINY.mutators + 13


@pytest.mark.parametrize("event", ["start", "write", "rank", "generation"])
@as_test(partial(simulate, TINY))
async def test_ranking_is_discarded(ctx, dut, event):
    rng = random.Random(5)
    driver = Driver(ctx, dut, rng)
    order = shuffled(rng, TINY)
    for wait in range(TINY.mutators + 16):
        await driver.rank(order)
        # The event occurs while the ranking is processed, or later.
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


@as_test(partial(simulate, TINY))
async def test_results_stay_until_the_next_generation(ctx, dut):
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


@as_test(partial(simulate, TINY))
async def test_nothing_is_accepted_during_a_generation(ctx, dut):
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


SMALL = TINY.replace(checker=CheckerBuild.PARALLEL, box_percent=60)
MAP_CONFIGS = {
    "small": SMALL,
    "no_redraws": SMALL.replace(redraws=0),
    "most_redraws": SMALL.replace(redraws=7, max_waypoints=5),
    "near_memory": SMALL.replace(memory_latency=1),
    "longest": SMALL.replace(max_waypoints=20, checker=CheckerBuild.TWO_TIER, lanes=1),
    "more_patches": SMALL.replace(max_waypoints=5, survivors=1, elites=1, children=6, inserts=3),
}


def highest(config):
    """Return limits that only keep new waypoints on the map."""
    return Limits(config.map_size - 1, config.map_size - 1, config.blocked_altitude - 1)


@pytest.mark.parametrize("name", MAP_CONFIGS)
def test_matches_model_with_a_map(name):
    """Maps are hit often, with or without avoidance of the ground; loads and reads come between."""
    config = MAP_CONFIGS[name]

    async def bench(ctx, dut):
        rng = random.Random(name)
        driver = Driver(ctx, dut, rng, (0, 2, 0, 1) if name == "more_patches" else (0,))
        left_out = redrawn = waited = refused = 0
        await fill(driver)
        for generation in range(18):
            if generation % 6 == 0:
                driver.survey(highest=rng.choice((4, 9, 15)))
                # Initially the ground does not matter.
                avoids = generation > 0
                limits = rng.choice((None, highest(config)))
                await driver.start(rng.getrandbits(64), limits=limits, avoid_ground=avoids)
            done = await driver.generate(shuffled(rng, config))
            if not avoids:
                assert not done.left_out
                assert not done.redrawn
            left_out += done.left_out
            redrawn += done.redrawn
            refused += done.refused
            waited += done.mutation_cycles > 2
            if generation % 4 == 1:
                await driver.load(rng.randrange(config.population), driver.path())
            if generation % 6 == 2:
                slot = rng.randrange(config.population)
                count = rng.randint(1, config.population - slot)
                assert await driver.read(slot, count) == driver.model.paths[slot : slot + count]
        await driver.check_population()
        counters = ctx.get(dut.counters)
        assert (counters[Counter.LEFT_OUT], counters[Counter.REDRAWN]) == (left_out, redrawn)
        assert counters[Counter.REFUSED_MUTATIONS] == refused
        assert left_out > 0
        assert (refused > 0) == (name != "longest")
        assert (redrawn > 0) == (config.redraws > 0)
        assert waited > 0

    simulate(config, bench)


def test_new_waypoints_are_above_the_ground():
    """Only the results are checked: the cell of each is lower, and was looked up in its turn."""
    config = SMALL.replace(redraws=1)

    async def bench(ctx, dut):
        rng = random.Random(11)
        driver = Driver(ctx, dut, rng)
        driver.survey(lowest=3, highest=12)
        await driver.start(1, limits=highest(config), avoid_ground=True)
        kinds = []
        for generation in range(20):
            if generation % 3 == 0:
                await fill(driver, 3)
            done = await driver.generate(shuffled(rng, config))
            heights = driver.terrain.heights
            for number, mutated in enumerate(done.mutations[: config.patches]):
                x, y = mutated.waypoint & 15, mutated.waypoint >> 4 & 15
                tried = driver.lookups[number :: config.patches]
                if mutated.applied:
                    assert mutated.waypoint >> 8 > heights[y, x]
                    assert tried[mutated.redraws] == (x, y)
                elif mutated.left_out:
                    assert len(tried) == config.candidates
                kinds.append((mutated.kind, mutated.applied, mutated.redraws))
        for kind in (MutationKind.PERTURB, MutationKind.INSERT):
            assert {(kind, True, 0), (kind, True, 1), (kind, False, 1)} <= set(kinds)

    simulate(config, bench)


@pytest.mark.ci
@pytest.mark.parametrize(("memory_latency", "redraws"), [(2, 0), (2, 2), (2, 7), (1, 2)])
def test_cycles_of_a_generation(memory_latency, redraws):
    """All are above the ground, then all in it; the paths are the shortest, then the longest."""
    config = SMALL.replace(max_waypoints=20, memory_latency=memory_latency, redraws=redraws)
    lookup = 2 + memory_latency
    assert config.lookup_latency == lookup

    async def bench(ctx, dut):
        rng = random.Random(12)
        driver = Driver(ctx, dut, rng)
        for ground, candidates in ((0, 2), (config.blocked_altitude, 2 * (1 + redraws))):
            driver.survey(ground, ground)
            for length in (2, 20):
                # A candidate at altitude 0 would not be above the ground there.
                await driver.start(5, limits=highest(config), avoid_ground=ground > 0)
                await fill(driver, length)
                await driver.generate(shuffled(rng, config))
                needed = candidates
                if length == 20:
                    # No path has room to insert: the last candidate is the perturbing mutator's.
                    needed = candidates - 1
                expected = max(length + 4, needed + lookup + 6)
                assert ctx.get(dut.counters)[Counter.LONGEST] == expected

    simulate(config, bench)


def test_all_redraws_hide_behind_the_longest_paths():
    """The default sizes are used; the requirement is ``max_waypoints + 8`` cycles."""
    config = Config(checker=CheckerBuild.PARALLEL)
    needed = config.patches * config.candidates
    assert needed + config.lookup_latency + 6 == 19 <= config.max_waypoints + 4


@as_test(partial(simulate, SMALL))
async def test_cycles_of_a_ranking_with_a_map(ctx, dut):
    driver = Driver(ctx, dut, random.Random(4))
    await driver.rank(range(SMALL.population))
    assert await ranked_after(driver) == SMALL.mutators + SMALL.patches + 18


@pytest.mark.ci
@pytest.mark.parametrize("event", ["start", "write", "rank", "generation", "read"])
def test_event_while_waypoints_are_read_ahead(event):
    """It occurs in every cycle. All events except a read discard the ranking; a read delays it."""
    cycles = SMALL.mutators + SMALL.patches + 22

    async def bench(ctx, dut):
        rng = random.Random(5)
        driver = Driver(ctx, dut, rng)
        driver.survey(highest=9)
        await driver.start(3, limits=highest(SMALL), avoid_ground=True)
        order = shuffled(rng, SMALL)
        for wait in range(cycles):
            await driver.rank(order)
            for _ in range(wait):
                await driver.tick()
            match event:
                case "start":
                    await driver.start(wait, limits=highest(SMALL), avoid_ground=True)
                case "write":
                    await driver.load(1, driver.path())
                case "rank":
                    await driver.rank([3])
                case "generation":
                    await driver.generate(order)
                case "read":
                    assert await driver.read(1, 2) == driver.model.paths[1:3]
                    await ranked_after(driver)
                    await driver.generate(shuffled(rng, SMALL))
                    continue
            for _ in range(cycles):
                assert not ctx.get(dut.ranked)
                await driver.tick()
        await driver.generate(order)
        await driver.check_population()

    simulate(SMALL, bench)
