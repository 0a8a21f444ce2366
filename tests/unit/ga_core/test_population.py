"""The population: host access, lockstep reading, copies, the update, pending mutations."""

import itertools
import random

import pytest

from pathgene.hdl.config import CheckerBuild, MutationKind
from pathgene.hdl.ga_core.crossover import parents_of
from pathgene.hdl.ga_core.population import Population
from pathgene.hdl.ga_core.read_ports import PEEK_LATENCY
from tests.support.gateware.chips import TINY, random_path, random_paths
from tests.support.gateware.streams import as_test, pulse, put, resettable, shared, simulate


SMALL = TINY.replace(inserts=2, max_waypoints=5)
KEPT = SMALL.elites + SMALL.survivors
#: Cycles from a read to its first waypoint, and between two paths.
FIRST, BETWEEN = 5, 3


async def load(ctx, dut, slot, path):
    for index, waypoint in enumerate(path):
        last = index == len(path) - 1
        word = {"slot": slot, "index": index, "waypoint": waypoint, "last": last}
        await put(ctx, dut.writes, word)


async def loaded(ctx, dut, rng, length=None):
    """Load a random path into every slot; return the paths."""
    paths = random_paths(dut.config, rng, length)
    for slot, path in enumerate(paths):
        await load(ctx, dut, slot, path)
    return paths


async def read(ctx, dut, slot, count, pauses=(0,)):
    """Return the paths of ``count`` slots."""
    await put(ctx, dut.reads, {"slot": slot, "count": count})
    paths = [[]]
    ready = itertools.cycle(cycle for pause in pauses for cycle in [*[0] * pause, 1])
    for _ in range(100 * count):
        ctx.set(dut.read_waypoints.ready, next(ready))
        _, _, valid, taken, word = await ctx.tick().sample(
            dut.read_waypoints.valid, dut.read_waypoints.ready, dut.read_waypoints.payload
        )
        if valid and taken:
            paths[-1].append(word.waypoint)
            if word.final:
                ctx.set(dut.read_waypoints.ready, 0)
                assert word.last
                return paths
            if word.last:
                paths.append([])
    raise TimeoutError("No end of a read")


async def settle(ctx, dut):
    cycles = 0
    while not ctx.get(dut.settled):
        await ctx.tick()
        cycles += 1
        assert cycles < 20
    return cycles


async def breed(ctx, dut, paths, carried, mutations=(), patches=()):
    """Read the paths of ``carried`` in lockstep, so that children are bred, and update.

    ``mutations`` are (number, child, index); returns the next population.
    """
    config = dut.config
    kept = config.elites + config.survivors
    ctx.set(dut.allow, 0)
    for port, slot in zip(dut.carried, carried, strict=True):
        ctx.set(port, {"slot": slot, "length": len(paths[slot]), "select": 1 << slot})
    for _ in range(3):
        await ctx.tick()
    await settle(ctx, dut)

    bred = [paths[slot] for slot in carried]
    longest = max(map(len, bred))
    await pulse(ctx, dut.launch)
    await ctx.tick()
    for cycle in range(longest + 1):
        assert ctx.get(dut.carrying) == (cycle > 0)
        if cycle:
            position = cycle - 1
            assert ctx.get(dut.position) == position
            for port, path in zip(dut.waypoints, bred, strict=True):
                if position < len(path):
                    assert ctx.get(port) == path[position]
        assert ctx.get(dut.done) == (cycle == longest)
        await ctx.tick()
    assert not ctx.get(dut.done)

    children = []
    for child in range(config.children):
        head, tail = (bred[kept + parent] for parent in parents_of(child, config.crossovers))
        children.append(head[: len(head) // 2] + tail[len(tail) // 2 :])
    for port, patch in zip(dut.patches, patches, strict=False):
        ctx.set(port, patch)
    for number, child, index in mutations:
        ctx.set(dut.mutations[number], {"applied": 1, "child": child, "index": index})
        match config.mutations[number]:
            case MutationKind.PERTURB:
                children[child][index] = patches[number]
            case MutationKind.INSERT:
                children[child].insert(index + 1, patches[number])
            case MutationKind.DELETE:
                del children[child][index]

    await ctx.tick()
    ctx.set(dut.update, 1)
    for mutation in dut.mutations:
        # An index without `applied` is not a mutation; in the cycle of the update it is ignored.
        ctx.set(mutation, {"applied": 0, "child": 1, "index": 1})
    await ctx.tick()
    ctx.set(dut.update, 0)
    ctx.set(dut.allow, 1)
    following = bred[:kept] + children
    assert [ctx.get(length) for length in dut.lengths] == list(map(len, following))
    assert await settle(ctx, dut) <= 3
    return following


def bench_of(function, config=SMALL):
    """Run ``function(ctx, dut)`` as the only test bench."""
    dut = shared(Population, config)

    async def testbench(ctx):
        ctx.set(dut.allow, 1)
        await function(ctx, dut)

    simulate(dut, testbench)


@as_test(bench_of)
async def test_reset(ctx, dut):
    assert await read(ctx, dut, 0, SMALL.population) == [[0, 0]] * SMALL.population


@pytest.mark.ci
@pytest.mark.parametrize("pauses", [(0,), (0, 1, 3)], ids=["steady", "stalled"])
@pytest.mark.parametrize("max_waypoints", [3, 5, 8])
def test_reads_return_writes(max_waypoints, pauses):
    config = SMALL.replace(max_waypoints=max_waypoints)

    async def bench(ctx, dut):
        rng = random.Random(1)
        paths = [[0, 0]] * config.population
        for slot in rng.sample(range(config.population), config.population):
            for _ in range(2):
                paths[slot] = random_path(config, rng)
                await load(ctx, dut, slot, paths[slot])
            count = rng.randint(1, config.population - slot)
            assert await read(ctx, dut, slot, count, pauses) == paths[slot : slot + count]
            assert [ctx.get(length) for length in dut.lengths] == list(map(len, paths))
        assert await read(ctx, dut, 0, config.population, pauses) == paths

    bench_of(bench, config)


def test_cycles_of_a_read():
    dut = shared(Population, SMALL)
    words = []
    rng = random.Random(2)
    paths = [random_path(SMALL, rng) for _ in range(3)]
    seen = []

    async def testbench(ctx):
        ctx.set(dut.allow, 1)
        for slot, path in enumerate(paths):
            await load(ctx, dut, slot, path)
        await put(ctx, dut.reads, {"slot": 0, "count": 3})
        cycle = 1
        # Neither stream is accepted while a read is in flight.
        while not ctx.get(dut.writes.ready):
            assert not ctx.get(dut.reads.ready)
            assert not ctx.get(dut.settled)
            if ctx.get(dut.read_waypoints.valid):
                seen.append(cycle)
            await ctx.tick()
            cycle += 1
        assert await settle(ctx, dut) <= 3

    async def collector(ctx):
        ctx.set(dut.read_waypoints.ready, 1)
        while True:
            _, _, valid, word = await ctx.tick().sample(
                dut.read_waypoints.valid, dut.read_waypoints.payload
            )
            if valid:
                words.append(word.waypoint)

    simulate(dut, testbench, background=[collector])
    assert words == list(itertools.chain(*paths))
    expected = []
    cycle = FIRST
    for path in paths:
        expected += range(cycle, cycle + len(path))
        cycle += len(path) + BETWEEN
    assert seen == expected


@as_test(bench_of)
async def test_nothing_is_accepted_unless_allowed(ctx, dut):
    ctx.set(dut.allow, 0)
    for flow in (dut.reads, dut.writes):
        ctx.set(flow.valid, 1)
    for _ in range(8):
        assert not ctx.get(dut.reads.ready)
        assert not ctx.get(dut.writes.ready)
        await ctx.tick()
    assert ctx.get(dut.settled)


@as_test(bench_of)
async def test_generations_without_mutations(ctx, dut):
    """Copies and children span several updates, so that both banks are read and written."""
    rng = random.Random(3)
    paths = await loaded(ctx, dut, rng)
    for _ in range(6):
        carried = rng.choices(range(SMALL.population), k=len(dut.carried))
        paths = await breed(ctx, dut, paths, carried)
        assert await read(ctx, dut, 0, SMALL.population) == paths


@pytest.mark.parametrize("number", range(4), ids=["perturb", "insert_0", "insert_1", "delete"])
@as_test(bench_of)
async def test_every_index_of_a_mutation(ctx, dut, number):
    """A mutation at each index of a child is read once from its halves and once from a copy."""
    rng = random.Random(number)
    # Halves of 2 and 2: a child of 4 waypoints, which may grow and shrink.
    paths = [random_path(SMALL, rng, 4) for _ in range(SMALL.population)]
    for index in range(4):
        child = (index + number) % SMALL.children
        for slot, path in enumerate(paths):
            await load(ctx, dut, slot, path)
        patches = [rng.getrandbits(SMALL.waypoint_bits) for _ in range(SMALL.patches)]
        carried = rng.choices(range(SMALL.population), k=len(dut.carried))
        mutated = await breed(ctx, dut, paths, carried, [(number, child, index)], patches)
        assert await read(ctx, dut, KEPT + child, 1) == [mutated[KEPT + child]]
        again = await breed(ctx, dut, mutated, [KEPT + child] * len(dut.carried))
        assert await read(ctx, dut, 0, SMALL.population) == again


def test_waypoints_are_read_ahead():
    """All positions work, even with pending mutations; later reading starts at 0."""
    config = SMALL.replace(checker=CheckerBuild.PARALLEL)

    async def bench(ctx, dut):
        rng = random.Random(8)
        paths = await loaded(ctx, dut, rng, 4)
        patches = [rng.getrandbits(config.waypoint_bits) for _ in range(config.patches)]
        mutations = [(0, 0, 1), (1, 1, 0), (2, 2, 3), (3, 3, 0)]
        for count in (1, 2, 3, 8):
            carried = rng.choices(range(config.population), k=len(dut.carried))
            paths = await breed(ctx, dut, paths, carried, mutations, patches)
            mutations = []

            carried = rng.choices(range(config.population), k=len(dut.carried))
            for port, slot in zip(dut.carried, carried, strict=True):
                ctx.set(port, {"slot": slot, "length": len(paths[slot]), "select": 1 << slot})
            await ctx.tick()
            ctx.set(dut.reads.valid, 1)
            ctx.set(dut.reads.payload, {"slot": 1, "count": 2})
            positions = [rng.randrange(config.max_waypoints) for _ in range(count)]
            for cycle in range(count + 5):
                ctx.set(dut.peeks, cycle < count)
                ctx.set(dut.peek, cycle < count)
                if cycle < count:
                    ctx.set(dut.peek_position, positions[cycle])
                assert ctx.get(dut.settled) == (cycle == 0)
                # A read is accepted as soon as the waypoints of the last peek have passed.
                assert ctx.get(dut.reads.ready) == (cycle >= count + PEEK_LATENCY - 1)
                if ctx.get(dut.reads.ready):
                    ctx.set(dut.reads.valid, 0)
                if PEEK_LATENCY <= cycle < count + PEEK_LATENCY:
                    position = positions[cycle - PEEK_LATENCY]
                    for port, slot in zip(dut.waypoints, carried, strict=True):
                        if position < len(paths[slot]):
                            assert ctx.get(port) == paths[slot][position]
                await ctx.tick()
            assert await settle(ctx, dut) == 0
            assert await read(ctx, dut, 0, config.population) == paths

    bench_of(bench, config)


def test_read_after_reading_ahead():
    """The read comes in the cycle after a peek or in any later one."""
    config = SMALL.replace(checker=CheckerBuild.PARALLEL)

    async def bench(ctx, dut):
        rng = random.Random(9)
        paths = await loaded(ctx, dut, rng)
        for wait in range(9):
            await settle(ctx, dut)
            ctx.set(dut.peeks, 1)
            ctx.set(dut.peek, 1)
            ctx.set(dut.peek_position, wait % config.max_waypoints)
            await ctx.tick()
            ctx.set(dut.peeks, 0)
            ctx.set(dut.peek, 0)
            for _ in range(wait):
                await ctx.tick()
            assert await read(ctx, dut, 2, 3) == paths[2:5]

    bench_of(bench, config)


def test_write_ends_reading_ahead():
    """The write comes in every cycle of the reading ahead."""
    config = SMALL.replace(checker=CheckerBuild.PARALLEL)

    async def bench(ctx, dut):
        rng = random.Random(10)
        paths = await loaded(ctx, dut, rng)
        for wait in range(9):
            await settle(ctx, dut)
            for cycle in range(wait):
                ctx.set(dut.peeks, cycle < 3)
                ctx.set(dut.peek, cycle < 3)
                await ctx.tick()
            # The last waypoint may be read ahead while the first is written.
            ctx.set(dut.peeks, wait < 3)
            ctx.set(dut.peek, wait < 3)
            slot = rng.randrange(config.population)
            paths[slot] = random_path(config, rng)
            last = len(paths[slot]) - 1
            for index, waypoint in enumerate(paths[slot]):
                word = {"slot": slot, "index": index, "waypoint": waypoint, "last": index == last}
                await put(ctx, dut.writes, word)
                ctx.set(dut.peeks, 0)
                ctx.set(dut.peek, 0)
            carried = rng.choices(range(config.population), k=len(dut.carried))
            paths = await breed(ctx, dut, paths, carried)
            assert await read(ctx, dut, 0, config.population) == paths

    bench_of(bench, config)


@as_test(bench_of)
async def test_loading_a_path_discards_its_mutation(ctx, dut):
    rng = random.Random(7)
    paths = await loaded(ctx, dut, rng, 4)
    patches = [rng.getrandbits(SMALL.waypoint_bits) for _ in range(SMALL.patches)]
    mutations = [(0, 0, 1), (1, 1, 0), (2, 2, 3), (3, 3, 0)]
    carried = rng.choices(range(SMALL.population), k=len(dut.carried))
    paths = await breed(ctx, dut, paths, carried, mutations, patches)
    for child in range(SMALL.children):
        paths[KEPT + child] = random_path(SMALL, rng)
        await load(ctx, dut, KEPT + child, paths[KEPT + child])
        assert await read(ctx, dut, 0, SMALL.population) == paths


@pytest.mark.parametrize("cycles", [1, 2])
def test_reset_discards_mutations(cycles):
    """Each path read ahead afterwards has two waypoints from bank 0, and no patch."""
    dut = shared(Population, SMALL)
    top, rst = resettable(dut)

    async def testbench(ctx):
        rng = random.Random(11)
        ctx.set(dut.allow, 1)
        before = await loaded(ctx, dut, rng, 4)
        patches = [rng.getrandbits(SMALL.waypoint_bits) for _ in range(SMALL.patches)]
        mutations = [(0, 0, 0), (1, 1, 0), (2, 2, 1), (3, 3, 0)]
        carried = rng.choices(range(SMALL.population), k=len(dut.carried))
        await breed(ctx, dut, before, carried, mutations, patches)

        ctx.set(rst, 1)
        for _ in range(cycles):
            await ctx.tick()
        ctx.set(rst, 0)
        paths = [path[:2] for path in before]
        carried = [KEPT + port % SMALL.children for port in range(len(dut.carried))]
        paths = await breed(ctx, dut, paths, carried)
        assert await read(ctx, dut, 0, SMALL.population) == paths

    simulate(top, testbench)
