"""The evolver compared with the definition, generation by generation, and all its cycles."""

import itertools

import pytest

from pathgene.hdl.planner.layouts import slot_count
from pathgene.hdl.protocol.planner import VALUE_BITS, PathClass
from pathgene.sim.model.planner import evolver_cycles
from tests.support.gateware.streams import pulse
from tests.support.planner.cases import SMALL, USUAL
from tests.support.planner.evolver_bench import Bench
from tests.support.planner.plain import Sorting
from tests.support.planner.population import TINY


#: A chip with just enough slots for the children of two generations.
TIGHT = SMALL.replace(population=16, children=10, elites=2, survivors=4)


def check_ready(bench):
    """Compare ``ready`` and the cycles in which keys are taken with the model."""
    size, children = bench.config.population, bench.config.children
    passes = iter(bench.stays)
    sorting, free, ready = Sorting(size), 0, 0
    # First cycle and ranks of the next pass; children that have arrived.
    first, ranks, came = None, 0, 0
    collecting = merging = False
    for now, cycle in enumerate(bench.cycles):
        if first is not None and now >= max(first, free):
            stay = next(passes)
            passed = sum(sorting.insert(key, late=False) for key in stay)
            free = now + evolver_cycles.passing_over(ranks, len(stay), passed)
            first = None
        assert cycle.ready == (not collecting and now >= ready), now
        assert cycle.accepts == (now >= free and came < children), now
        if cycle.key is not None:
            passed = sorting.insert(cycle.key, late=True)
            free = evolver_cycles.inserted(now, passed)
            came += not cycle.fills
        if cycle.store:
            ready = free = evolver_cycles.settled(now, free, size)
            sorting = Sorting(size)
        elif cycle.merge:
            first, ranks = evolver_cycles.passing(now, 0), 2 * size
            collecting = merging = True
        elif (cycle.begin or cycle.finish) and cycle.pending:
            first, ranks = evolver_cycles.passing(now, children if cycle.begin else 0), size
            collecting = True
        elif cycle.begin:
            ready = now + evolver_cycles.planning(children)
        elif collecting and first is None and now >= free and (came == children or merging):
            ready = free = evolver_cycles.ready(now, size)
            sorting, came, collecting, merging = Sorting(size), 0, False, False
    assert not any(passes)


def begun(bench):
    """Return the cycles in which the model begins the children."""
    begins = [i for i, cycle in enumerate(bench.cycles) if cycle.begin]
    at, points, cycles = 0, 0, []
    for number, length in enumerate(bench.lengths):
        generation, child = divmod(number, bench.config.children)
        at = evolver_cycles.begun(evolver_cycles.plan(begins[generation], child), at, points)
        points = length
        cycles.append(at)
    return cycles


def check_points(bench, *, every):
    """Compare the cycles in which points are taken, one in ``every``, with the model's."""
    expected, free = [], 0
    for start, length in zip(begun(bench), bench.lengths, strict=True):
        for point in range(length):
            at = max(evolver_cycles.offered(start, point), free)
            expected.append(at + -at % every)
            free = expected[-1] + every
    taken = [i for i, cycle in enumerate(bench.cycles) if cycle.points]
    assert taken == expected


async def evolve(bench, ctx, island, generations, compares=()):
    """Breed generations, comparing the population before some of them; collect all."""
    for generation in range(generations):
        if generation in compares:
            await bench.compare(ctx, island)
        for _ in range(int(bench.rng.choice([0, 0, 1, 300]))):
            await ctx.tick()
        await bench.begin(ctx, island)
        assert ctx.get(bench.dut.best) == bench.bred_from[0].key
    await bench.finish(ctx, island)
    await bench.compare(ctx, island)


PACES = {
    "fast": {"pace": "fast"},
    "fast-late": {"pace": "fast", "latency": 90},
    "scorer": {"pace": "scorer", "latency": 60},
    "stalled": {"pace": "stalled", "latency": 40},
}


@pytest.mark.parametrize("pace", PACES)
@pytest.mark.parametrize(
    "config",
    [pytest.param(TINY, id="tiny"), pytest.param(SMALL, id="small", marks=pytest.mark.ci)],
)
def test_generations(config, pace):
    """Two islands alternate, then their best become one population; equal keys are frequent."""
    bench = Bench(config, 7, **PACES[pace])

    async def run(ctx):
        await bench.start(ctx)
        for island, more in enumerate((9, 0)):
            await bench.fill(ctx, island, config.population + more)
            await bench.compare(ctx, island)
        await evolve(bench, ctx, 0, 12, compares=(0, 1, 2, 6))
        await evolve(bench, ctx, 1, 3)
        await evolve(bench, ctx, 1, 1)
        await bench.compare(ctx, 0)
        await bench.merge(ctx)
        await bench.compare(ctx, 0)
        await evolve(bench, ctx, 0, 12, compares=(1, 2))

    bench.simulate(run)
    check_ready(bench)
    if pace != "stalled":
        check_points(bench, every=2 if pace == "scorer" else 1)
    if pace == "fast-late":
        taken = [i for i, cycle in enumerate(bench.cycles) if cycle.children]
        assert taken == begun(bench)


@pytest.mark.ci
@pytest.mark.parametrize(
    ("config", "generations"),
    [
        pytest.param(SMALL, 8, id="short"),
        pytest.param(SMALL, 30, id="small", marks=pytest.mark.long),
        pytest.param(USUAL, 6, id="usual", marks=pytest.mark.long),
    ],
)
def test_evaluated_by_the_definition(config, generations):
    bench = Bench(config, 7, pace="scorer", any_key=False, latency=145)

    async def run(ctx):
        await bench.start(ctx)
        for island in range(2):
            await bench.fill(ctx, island, config.population + 9)
        for island in range(2):
            await evolve(bench, ctx, island, generations)
        await bench.merge(ctx)
        await evolve(bench, ctx, 0, generations)

    bench.simulate(run)
    check_ready(bench)
    check_points(bench, every=2)
    classes = {key >> VALUE_BITS for key in bench.keys}
    assert PathClass.INFEASIBLE in classes
    if config is SMALL:
        assert classes == {PathClass.FEASIBLE, PathClass.GIVEN_UP, PathClass.INFEASIBLE}


@pytest.mark.ci
@pytest.mark.parametrize("pace", [pytest.param("fast", marks=pytest.mark.long), "stalled"])
@pytest.mark.parametrize(
    "config",
    [
        pytest.param(TINY, id="tiny"),
        pytest.param(SMALL, id="small", marks=pytest.mark.long),
        pytest.param(TIGHT, id="tight", marks=pytest.mark.long),
    ],
)
def test_runs_go_on(config, pace):
    """Populations revised in place, and runs without ``clear``: no slot is lost or used twice."""
    bench = Bench(config, 3, pace=pace, latency=20)
    assert bench.dut.slot_count == 2 * config.population + max(2 * config.children, 18)

    async def run(ctx):
        await bench.start(ctx)
        await bench.fill(ctx, 0, 2 * config.population)
        for _ in range(2):
            await bench.revise(ctx, 0)
            await bench.compare(ctx, 0)
        for number in range(4):
            if number:
                await bench.revise(ctx, 0)
            await bench.fill(ctx, 1, 3 * config.population)
            await bench.revise(ctx, 1)
            for island in range(2):
                await evolve(bench, ctx, island, 5)
            await bench.merge(ctx)
            await evolve(bench, ctx, 0, 5)

    bench.simulate(run)
    check_ready(bench)
    generations = sum(cycle.begin for cycle in bench.cycles)
    assert generations == 60


def test_one_island():
    """``merge`` does nothing, and neither does ``finish`` with nothing pending."""
    bench = Bench(SMALL, 5, islands=1)

    async def run(ctx):
        await bench.start(ctx)
        await bench.fill(ctx, 0, 20)
        for signal in (bench.dut.merge, bench.dut.finish):
            await pulse(ctx, signal)
            for _ in range(3):
                assert ctx.get(bench.dut.ready)
                await ctx.tick()
        await evolve(bench, ctx, 0, 10, compares=(0, 3))
        await bench.revise(ctx, 0)
        await evolve(bench, ctx, 0, 10)

    bench.simulate(run)


@pytest.mark.ci
def test_reset():
    """After a reset in any part of a generation, a run is the same as the first one."""
    bench = Bench(SMALL, 11, latency=10)

    async def run(ctx):
        for wait in itertools.chain(range(1, 40, 3), range(41, 90, 7)):
            await bench.start(ctx)
            await bench.fill(ctx, 0, 12)
            await bench.compare(ctx, 0)
            for _ in range(1 + wait % 2):
                await bench.begin(ctx, 0)
            bench.breed(0)
            await pulse(ctx, bench.dut.begin)
            await ctx.tick().repeat(wait)
            await bench.reset(ctx)
        await bench.start(ctx)
        await bench.fill(ctx, 0, 12)
        await evolve(bench, ctx, 0, 6, compares=(1, 4))

    bench.simulate(run)
    check_ready(bench)


def test_slots():
    """The slots hold populations, and children of two generations or seeds in flight."""
    assert [slot_count(USUAL, islands) for islands in (1, 2)] == [76, 108]
    assert [slot_count(SMALL, islands) for islands in (1, 2)] == [26, 34]
