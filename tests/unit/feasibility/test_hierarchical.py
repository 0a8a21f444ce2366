# amaranth: UnusedElaboratable=no
"""The hierarchical build in Amaranth's simulator: all numbers of lanes, small maps."""

import numpy as np
import pytest

from hdl.config import CheckerBuild, Config
from hdl.feasibility.checker import Checker
from sim.model.checker import TerrainModel, check_path, segment_cells
from sim.model.checker_clocks import batch_clocks
from tests.checking import ground, paths_of, random_batch
from tests.streams import collect, simulate
from tests.unit.feasibility.checks import feed, look_up, results_of, summary, upload


TINY = Config(
    max_waypoints=4,
    map_size=8,
    coarse_factor=2,
    altitude_bits=4,
    checker=CheckerBuild.HIERARCHICAL,
    lanes=1,
)
SMALL = TINY.replace(map_size=16, coarse_factor=4, altitude_bits=6)
#: Lanes, and cells of a block: fewer lanes than these, as many, and more.
SHAPES = [(1, 4), (2, 8), (4, 4), (8, 2), (16, 8)]


def batch(config, seed, paths, peaks=0.02):
    rng = np.random.default_rng(seed)
    terrain = ground(config, rng, peaks=peaks, blocked=0.01)
    return terrain, paths_of(random_batch(config, rng, paths))


def expected(config, terrain, paths, count=False):
    """Verdicts of a full check of every segment in the detailed map."""
    detailed = config.replace(checker=CheckerBuild.PARALLEL)
    return [summary(check_path(detailed, terrain, path, count)) for path in paths]


@pytest.mark.parametrize("count", [False, True], ids=["first", "count"])
@pytest.mark.parametrize(("lanes", "factor"), SHAPES)
def test_queue_equals_full_check(lanes, factor, count):
    """Verdicts, counts, cycles and reads of paths without a gap between them."""
    latency = 1 + count
    config = SMALL.replace(lanes=lanes, coarse_factor=factor, memory_latency=latency)
    terrain, paths = batch(config, 10 * lanes, 20 if lanes < 16 else 10)
    results = results_of(Checker(config), terrain, paths, count=count)
    assert results.summaries == expected(config, terrain, paths, count)
    assert results.clocks == batch_clocks(config, terrain, paths, count)
    assert results.offered[-1] == sum(cycles for cycles, _ in results.clocks)
    assert {verdict.collision for verdict in results.verdicts} == {0, 1}
    assert {verdict.coarse for verdict in results.verdicts} == {0}


def test_dense_ground():
    """Nearly every column is walked: the queue of columns fills up, and its end is dropped."""
    config = SMALL.replace(lanes=1, coarse_factor=2, max_waypoints=8)
    terrain = ground(config, np.random.default_rng(5), peaks=0.25, blocked=0.01)
    paths = paths_of(random_batch(config, np.random.default_rng(6), 12))
    # Through free cells between the peaks, so that they are walked for long.
    paths += [[(0, 0, 40), (15, 15, 40)] * 4 for _ in range(3)]
    for count in (False, True):
        results = results_of(Checker(config), terrain, paths, count=count)
        assert results.summaries == expected(config, terrain, paths, count)
        assert results.clocks == batch_clocks(config, terrain, paths, count)


@pytest.mark.parametrize("lanes", [1, 4])
def test_paths_alone(lanes):
    config = SMALL.replace(lanes=lanes)
    terrain, paths = batch(config, lanes, 15)
    results = results_of(Checker(config), terrain, paths, alone=True)
    assert results.summaries == expected(config, terrain, paths)
    assert results.clocks == [batch_clocks(config, terrain, [path])[0] for path in paths]


@pytest.mark.parametrize("latency", [1, 2])
def test_clear_sky(latency):
    """A segment above all takes a clock and a read or two a column, whatever its cells."""
    config = SMALL.replace(map_size=32, coarse_factor=8, memory_latency=latency)
    dut = Checker(config)
    verdicts = []

    async def bench(ctx):
        await upload(ctx, dut, [[0]])  # All else is 0 in a simulation's memory.
        while not ctx.get(dut.points.ready):
            await ctx.tick()
        await feed(ctx, dut, [(0, 7, 9), (31, 7, 9)])
        await feed(ctx, dut, [(4, 0, 9), (4, 20, 9), (4, 3, 5)])
        while len(verdicts) < 2:
            await ctx.tick()

    async def read(ctx):
        await collect(ctx, dut.verdicts, verdicts)

    simulate(dut, bench, background=[read])
    straight, there_and_back = verdicts
    assert straight.cells == 32
    assert straight.reads == 4
    # Points 2, set-up 10, columns 4, then the last column's way through its test and the queue.
    assert straight.cycles == 2 + 10 + 4 + (latency + 2) + 1 + (latency + 3) + 1
    assert there_and_back.cells == 21 + 18
    assert there_and_back.reads == 3 + 3


def test_map_rises_and_falls():
    """Partial uploads: a block gets in the way, then its cell does, then neither."""
    path = [(0, 0, 9), (15, 15, 9)]
    terrain = TerrainModel(SMALL)
    terrain.write(0, 0, np.zeros((16, 16), dtype=int))
    dut = Checker(SMALL)
    verdicts, reads = [], []

    async def bench(ctx):
        await upload(ctx, dut, terrain.heights)
        changes = ((5, 6, 9), (6, 6, 9), (6, 6, 8), (5, 6, 8), (4, 4, 63), (4, 4, 0))
        for number, (x, y, altitude) in enumerate(changes, start=1):
            terrain.write(x, y, [[altitude]])
            await upload(ctx, dut, [[altitude]], x, y)
            await feed(ctx, dut, path)
            while len(verdicts) < number:
                await ctx.tick()
            verdict = verdicts[-1]
            reads.append(verdict.reads)
            outcome = check_path(SMALL, terrain, path)
            assert (bool(verdict.collision), verdict.x, verdict.y, verdict.cells) == (
                outcome.collision,
                outcome.x,
                outcome.y,
                outcome.cells,
            )

    async def read(ctx):
        await collect(ctx, dut.verdicts, verdicts)

    simulate(dut, bench, background=[read])
    assert [verdict.collision for verdict in verdicts] == [0, 1, 0, 0, 1, 0]
    columns = segment_cells(*path) // SMALL.coarse_factor
    assert reads[0] == reads[2] == columns + SMALL.coarse_factor
    assert reads[3] == reads[5] == columns


def test_looks_up():
    terrain, paths = batch(TINY, 5, 6)
    dut = Checker(TINY)
    cells = [(x, y) for y in range(8) for x in range(8)]
    found = []

    async def bench(ctx):
        await upload(ctx, dut, terrain.heights)
        ctx.set(dut.verdicts.ready, 1)
        for path in paths:
            await feed(ctx, dut, path)
        while ctx.get(dut.busy):
            await ctx.tick()
        found.extend(await look_up(ctx, dut, cells))

    simulate(dut, bench)
    assert found == [terrain.heights[y, x] for x, y in cells]


@pytest.mark.parametrize(
    ("pauses", "count_pauses"), [((0, 3, 40), (0,)), ((0,), (0, 60, 2))], ids=["verdicts", "counts"]
)
def test_nothing_is_lost_under_back_pressure(pauses, count_pauses):
    config = TINY.replace(lanes=2)
    terrain, paths = batch(config, 8, 25, peaks=0.2)
    results = results_of(
        Checker(config), terrain, paths, count=True, pauses=pauses, count_pauses=count_pauses
    )
    assert results.summaries == expected(config, terrain, paths, count=True)
    assert len(results.counts) > 30
