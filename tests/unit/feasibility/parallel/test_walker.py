"""The parallel build in Amaranth's simulator: small maps, 1 to 4 lanes.

8 and 16 lanes are tested compiled, in ``tests/cosim/test_parallel_checker.py``.
"""

import itertools
import random

import numpy as np
import pytest

from pathgene.hdl.config import CheckerBuild
from pathgene.hdl.feasibility.checker import Checker
from pathgene.hdl.feasibility.parallel.terrain_memory import TerrainMemory
from pathgene.sim.model.checker import TerrainModel, check_path, segment_cells
from pathgene.sim.model.checker_cycles import batch_cycles
from tests.support.gateware.checker_cases import (
    TINY,
    drawn,
    expected,
    feed,
    ground,
    look_up,
    paths_of,
    random_batch,
    results_of,
    upload,
)
from tests.support.gateware.streams import collect, pulse, shared, simulate


PAIR = TINY.replace(checker=CheckerBuild.PARALLEL, lanes=2)
SMALL = PAIR.replace(map_size=16, altitude_bits=6)
LANES = (1, 2, 4)


def flat(config, altitude=0):
    terrain = TerrainModel(config)
    terrain.write(0, 0, np.full((config.map_size,) * 2, altitude))
    return terrain


@pytest.mark.parametrize("count", [False, True], ids=["first", "count"])
@pytest.mark.parametrize("latency", [1, 2])
@pytest.mark.parametrize("lanes", LANES)
def test_queue_equals_model(lanes, latency, count):
    """Verdicts, counts, cycles and reads of paths without a gap between them."""
    config = SMALL.replace(lanes=lanes, memory_latency=latency)
    terrain, paths = drawn(config, seed=2 * lanes, paths=20, peaks=0.04, blocked=0.02)
    results = results_of(shared(Checker, config), terrain, paths, count=count)
    assert results.summaries == expected(config, terrain, paths, count)
    assert results.costs == batch_cycles(config, terrain, paths, count)
    assert {verdict.collision for verdict in results.verdicts} == {0, 1}


def test_widest_altitudes():
    """The products are too wide for a multiplier of 18 bits."""
    config = SMALL.replace(lanes=4, altitude_bits=16)
    terrain, paths = drawn(config, seed=16, paths=20)
    results = results_of(shared(Checker, config), terrain, paths)
    assert results.summaries == expected(config, terrain, paths)
    assert {verdict.collision for verdict in results.verdicts} == {0, 1}


@pytest.mark.ci
@pytest.mark.parametrize("lanes", [2, 4])
def test_every_segment_of_a_tiny_map(lanes):
    """All pairs of cells in one queue, with random altitudes and ground, including equal cells."""
    config = PAIR.replace(lanes=lanes)
    rng = np.random.default_rng(lanes)
    terrain = ground(config, rng, peaks=0.05, blocked=0.02)
    cells = list(itertools.product(range(config.map_size), repeat=2))
    paths = [
        [(*start, int(low)), (*stop, int(high))]
        for (start, stop), low, high in zip(
            itertools.product(cells, repeat=2),
            rng.integers(3, 16, len(cells) ** 2),
            rng.integers(3, 16, len(cells) ** 2),
            strict=True,
        )
    ]
    paths = paths[:: 5 if lanes == 2 else 7]  # All of them: tests/cosim/test_parallel_checker.py.
    results = results_of(shared(Checker, config), terrain, paths)
    assert results.summaries == expected(config, terrain, paths)
    assert results.costs == batch_cycles(config, terrain, paths)


@pytest.mark.parametrize("latency", [1, 2])
@pytest.mark.parametrize("lanes", LANES)
def test_latency_of_a_lone_path(lanes, latency):
    config = PAIR.replace(lanes=lanes, memory_latency=latency, map_size=max(8, lanes))
    terrain = flat(config)
    top = config.map_size - 1
    paths = [
        [(0, 0, 9), (0, 0, 9)],
        [(3, 5, 9), (top, 2, 15)],
        [(0, 0, 9), (top, 1, 9), (5, top, 12), (5, 4, 9)],
    ]
    results = results_of(shared(Checker, config), terrain, paths, alone=True)
    groups = [
        sum(-(-segment_cells(*ends) // lanes) for ends in itertools.pairwise(path))
        for path in paths
    ]
    assert [cycles for cycles, _ in results.costs] == [number + latency + 10 for number in groups]
    for path, cost in zip(paths, results.costs, strict=True):
        assert batch_cycles(config, terrain, [path]) == [cost]


def test_throughput_on_mixed_segments():
    """The offered cycles, not the checker's own counters, show 80 % of the lanes' rate."""
    config = SMALL.replace(lanes=2)
    rng = np.random.default_rng(6)
    terrain = flat(config)
    paths = paths_of(random_batch(config, rng, 30, points=6))
    results = results_of(shared(Checker, config), terrain, paths)
    assert not any(verdict.collision for verdict in results.verdicts)
    cells = sum(verdict.cells for verdict in results.verdicts)
    assert cells >= 0.8 * config.lanes * (results.offered[-1] - results.offered[0])
    # There is no cycle between free paths.
    assert results.offered[-1] == sum(cycles for cycles, _ in results.costs)


@pytest.mark.parametrize(
    ("pauses", "count_pauses"),
    [((0, 3, 40), (0,)), ((0,), (0, 30, 2)), ((25, 0, 0), (0, 1, 40))],
    ids=["verdicts", "counts", "both"],
)
def test_nothing_is_lost_under_back_pressure(pauses, count_pauses):
    config = PAIR.replace(lanes=4)
    terrain, paths = drawn(config, 8, 30, peaks=0.3, blocked=0.15)
    results = results_of(
        Checker(config), terrain, paths, count=True, pauses=pauses, count_pauses=count_pauses
    )
    assert results.summaries == expected(config, terrain, paths, count=True)
    assert len(results.counts) > 30


def test_counts_are_there_with_their_verdict():
    """A reader of verdicts, and of as many counts as each announces, never waits for a count."""
    config = PAIR.replace(lanes=2)
    terrain, paths = drawn(config, 9, 40, peaks=0.3, blocked=0.15)
    dut = shared(Checker, config)
    taken = []

    async def bench(ctx):
        await upload(ctx, dut, terrain.heights)
        ctx.set(dut.count, 1)
        for path in paths:
            await feed(ctx, dut, path)

    async def read(ctx):
        for _ in paths:
            verdicts = []
            while not verdicts:
                ctx.set(dut.verdicts.ready, 1)
                _, _, valid, verdict = await ctx.tick().sample(dut.verdicts.valid, dut.verdicts.p)
                verdicts += [verdict] if valid else []
            ctx.set(dut.verdicts.ready, 0)
            ctx.set(dut.counts.ready, 1)
            entries = []
            for _ in range(verdicts[0].entries):
                _, _, valid, count = await ctx.tick().sample(dut.counts.valid, dut.counts.p)
                assert valid
                entries.append((count.segment, count.terrain, count.nofly))
            ctx.set(dut.counts.ready, 0)
            taken.append(tuple(entries))

    simulate(dut, bench, read)
    assert taken == [check_path(config, terrain, path, count=True).entries for path in paths]


def test_a_hit_drops_the_rest_of_its_path():
    """The next path is decided long before the rest could have been walked."""
    config = SMALL.replace(lanes=2, max_waypoints=16, memory_latency=2)
    terrain = flat(config)
    terrain.write(1, 0, [[40]])
    top = config.map_size - 1
    long = [(0, 0, 30), *[(top * (i % 2), 0, 30) for i in range(1, 17)], (5, 5, 30)]
    paths = [long, [(2, 2, 30), (9, 2, 30)]]
    results = results_of(shared(Checker, config), terrain, paths)
    assert results.summaries == expected(config, terrain, paths)
    assert results.costs == batch_cycles(config, terrain, paths)
    # One group hits; in the cycles up to its step six more of the two segments are read.
    assert results.costs[0] == (13, 2 * (1 + 5))
    walked = sum(-(-segment_cells(*ends) // 2) for ends in itertools.pairwise(long))
    assert results.offered[1] < 45 < walked


def test_partial_uploads_raise_and_lower_the_ground():
    config = SMALL.replace(lanes=4)
    terrain = flat(config, altitude=5)
    rng = random.Random(3)
    dut = shared(Checker, config)
    path = [(0, 7, 20), (15, 8, 20)]
    seen = []

    async def bench(ctx):
        ctx.set(dut.verdicts.ready, 1)
        await upload(ctx, dut, terrain.heights)
        for number in range(12):
            if number % 2 == 0:
                width, height = rng.randint(1, 5), rng.randint(4, 6)
                x, y = rng.randint(0, 16 - width), rng.randint(4, 7)
            altitude = 0 if number % 2 else rng.choice((40, config.blocked_altitude))
            block = np.full((height, width), altitude)
            terrain.write(x, y, block)
            await upload(ctx, dut, block, x, y)
            await feed(ctx, dut, path)
            while True:
                _, _, valid, verdict = await ctx.tick().sample(dut.verdicts.valid, dut.verdicts.p)
                if valid:
                    break
            got = (bool(verdict.collision), verdict.x, verdict.y, verdict.cells)
            model = check_path(config, terrain, path)
            assert got == (model.collision, model.x, model.y, model.cells)
            seen.append(got[0])

    simulate(dut, bench)
    assert {(True, False), (False, True)} <= set(itertools.pairwise(seen))


@pytest.mark.parametrize("build", list(CheckerBuild)[1:], ids=str)
def test_writes_are_refused_while_busy(build):
    """In every build, the source has to wait until all verdicts are taken."""
    config = SMALL.replace(checker=build, lanes=1 if build is CheckerBuild.TWO_TIER else 2)
    terrain = flat(config)
    dut = shared(Checker, config)

    async def bench(ctx):
        await upload(ctx, dut, terrain.heights)
        assert not ctx.get(dut.busy)
        await feed(ctx, dut, [(0, 0, 9), (15, 15, 9)])
        # It would hit the cell offered now, were it written; the verdict is not taken for a while.
        ctx.set(dut.writes.p, {"x": 12, "y": 12, "altitude": 60, "last": 1})
        ctx.set(dut.writes.valid, 1)
        for _ in range(40):
            assert ctx.get(dut.busy)
            assert not ctx.get(dut.writes.ready)
            await ctx.tick()
        assert ctx.get(dut.verdicts.valid)
        assert not ctx.get(dut.verdicts.p.collision)
        ctx.set(dut.verdicts.ready, 1)
        await ctx.tick()
        assert not ctx.get(dut.busy)
        assert ctx.get(dut.writes.ready)
        await ctx.tick()
        ctx.set(dut.writes.valid, 0)
        # A later write counts for the next path.
        await feed(ctx, dut, [(0, 0, 9), (15, 15, 9)])
        *_, verdict = await ctx.tick().sample(dut.verdicts.p.collision).until(dut.verdicts.valid)
        assert verdict

    simulate(dut, bench)


@pytest.mark.parametrize("latency", [1, 2])
@pytest.mark.parametrize("lanes", LANES)
def test_lookups(lanes, latency):
    """One per cycle, with a latency of ``lookup_latency``; a cycle without one changes nothing."""
    config = PAIR.replace(lanes=lanes, memory_latency=latency, map_size=max(8, lanes))
    rng = np.random.default_rng(lanes)
    heights = rng.integers(0, 16, (config.map_size, config.map_size))
    cells = [(int(x), int(y)) for x, y in rng.integers(0, config.map_size, (50, 2))]
    dut = shared(Checker, config)
    assert config.lookup_latency == latency + 2
    found = []

    async def bench(ctx):
        await upload(ctx, dut, heights)
        await ctx.tick()
        found.extend(await look_up(ctx, dut, cells))

    simulate(dut, bench)
    assert found == [heights[y, x] for x, y in cells]


def test_flags():
    """Flags rise with the offer of the verdict and fall with the next path's first point."""
    config = SMALL.replace(lanes=4)
    terrain = flat(config)
    terrain.write(8, 8, [[50]])
    free, hitting = [(0, 0, 9), (15, 0, 9)], [(0, 8, 9), (15, 8, 9), (0, 0, 9)]
    dut = shared(Checker, config)
    taken = []

    async def bench(ctx):
        await upload(ctx, dut, terrain.heights)
        for path in (free, hitting, free):
            before = (ctx.get(dut.collision), ctx.get(dut.clear))
            (x, y, altitude), *rest = path
            point = {"x": x, "y": y, "altitude": altitude, "last": 0}
            ctx.set(dut.points.p, point)
            ctx.set(dut.points.valid, 1)
            assert (ctx.get(dut.collision), ctx.get(dut.clear)) == before
            await ctx.tick()
            ctx.set(dut.points.valid, 0)
            assert not ctx.get(dut.collision)
            assert not ctx.get(dut.clear)
            await feed(ctx, dut, rest)
            while not ctx.get(dut.verdicts.valid):
                assert not ctx.get(dut.collision)
                assert not ctx.get(dut.clear)
                await ctx.tick()
            assert ctx.get(dut.collision) == (path is hitting)
            assert ctx.get(dut.clear) == (path is free)
            await pulse(ctx, dut.verdicts.ready)
            taken.append(path)
            await ctx.tick().repeat(3)

    simulate(dut, bench)
    assert len(taken) == 3


def test_counting_raises_the_flag_at_the_first_hit():
    config = SMALL.replace(lanes=1)
    terrain = flat(config)
    terrain.write(1, 0, [[50]])
    dut = shared(Checker, config)
    offered = []

    async def bench(ctx):
        await upload(ctx, dut, terrain.heights)
        ctx.set(dut.count, 1)
        await feed(ctx, dut, [(0, 0, 9), (15, 0, 9)])
        while not ctx.get(dut.collision):
            await ctx.tick()
        assert not ctx.get(dut.verdicts.valid)
        cycles = 0
        while not ctx.get(dut.verdicts.valid):
            await ctx.tick()
            cycles += 1
        assert cycles == 14  # The cells after the colliding one.
        offered.append(ctx.get(dut.verdicts.p.cells))

    simulate(dut, bench, background=[collect(dut.counts, [])])
    assert offered == [2]


@pytest.mark.parametrize(("lanes", "edge"), [(1, 1), (2, 1), (4, 2), (8, 4), (16, 8)])
def test_banks_along_an_edge(lanes, edge):
    assert TerrainMemory(lanes, 5, 4, 1).bank_edge == edge
