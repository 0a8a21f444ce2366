"""The two-tier build: its maps, its cycles, its state after a hit; every segment, long queues.

The queues run at full speed, under Verilator.
"""

import itertools
from functools import partial

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.checker import Checker
from pathgene.sim.harness import VerilatedChecker
from pathgene.sim.model.checker import TerrainModel, check_path, segment_cells
from pathgene.sim.model.checker_cycles import batch_cycles
from tests.support.gateware.checker_cases import (
    TINY,
    check_verilated,
    defined,
    drawn,
    expected,
    feed,
    ground,
    look_up,
    paths_of,
    place_of,
    random_batch,
    results_of,
    upload,
)
from tests.support.gateware.streams import collect, put, shared, simulate


SMALL = TINY.replace(map_size=16, coarse_factor=4, altitude_bits=6)
#: A segment of 100 cells fits.
LONG = TINY.replace(map_size=128, coarse_factor=16, altitude_bits=12)


@pytest.mark.parametrize("count", [False, True], ids=["first", "count"])
@pytest.mark.parametrize(("base", "latency"), [(TINY, 2), (SMALL, 1)], ids=["tiny", "small"])
def test_queue_equals_model(base, latency, count):
    """Verdicts, counts, cycles and reads match for paths that follow without gaps."""
    config = base.replace(memory_latency=latency)
    terrain, paths = drawn(config, latency, 25)
    results = results_of(shared(Checker, config), terrain, paths, count=count)
    assert results.summaries == expected(config, terrain, paths, count)
    assert results.costs == batch_cycles(config, terrain, paths, count)
    assert results.offered[-1] == sum(cycles for cycles, _ in results.costs)
    assert {verdict.collision for verdict in results.verdicts} == {0, 1}
    assert {verdict.coarse for verdict in results.verdicts} == {0, 1}


def test_paths_alone():
    terrain, paths = drawn(SMALL, 3, 25)
    results = results_of(Checker(SMALL), terrain, paths, alone=True)
    assert results.summaries == expected(SMALL, terrain, paths)
    assert results.costs == [batch_cycles(SMALL, terrain, [path])[0] for path in paths]


@pytest.mark.parametrize("latency", [1, 2])
def test_testing_trajectory(latency):
    """The path has 55 + 100 free detailed cells, then coarse cells, the sixth of which collides.

    The paper takes 171 cycles from ``enable`` to the flag (table 2).
    """
    config = LONG.replace(memory_latency=latency)
    path = [(64, 120, 800), (118, 100, 600), (19, 3, 700), (127, 3, 700)]
    assert [segment_cells(*path[:2]), segment_cells(*path[1:3])] == [55, 100]
    dut = shared(Checker, config)
    rises = []

    async def bench(ctx):
        # Everything else in the simulated memory is 0. This cell is next to the third segment, not
        # under it.
        await upload(ctx, dut, [[900]], x=6 * config.coarse_factor + 5, y=9)
        while not ctx.get(dut.points.ready):
            await ctx.tick()
        await feed(ctx, dut, path)
        cycles = len(path)
        while not ctx.get(dut.collision):
            await ctx.tick()
            cycles += 1
            assert cycles < 200
        assert not ctx.get(dut.clear)
        rises.append(cycles + 1)
        verdict = ctx.get(dut.verdicts.payload)
        assert ctx.get(dut.verdicts.valid)
        assert (verdict.segment, verdict.x, verdict.y, verdict.coarse) == (2, 6, 0, 1)
        assert (verdict.cells, verdict.cycles) == (161, rises[-1])

    simulate(dut, bench)
    assert rises == [169 + latency]


def test_map_rises_and_falls():
    """After partial uploads the same path is free, hit in the coarse map, and free again."""
    path = [(0, 0, 9), (1, 1, 9), (2, 2, 9), (15, 2, 9)]
    terrain = TerrainModel(SMALL)
    terrain.write(0, 0, np.zeros((16, 16), dtype=int))
    dut = shared(Checker, SMALL)
    verdicts = []

    async def bench(ctx):
        await upload(ctx, dut, terrain.heights)
        for number, (x, y, cells) in enumerate(
            (
                (9, 3, [[9]]),
                (10, 2, [[12, 0], [5, 0]]),
                (9, 3, [[8]]),
                (10, 2, [[8], [1]]),
                (0, 1, [[63, 63]]),
                (0, 1, [[1, 2]]),
            ),
            start=1,
        ):
            terrain.write(x, y, cells)
            await upload(ctx, dut, cells, x, y)
            await feed(ctx, dut, path)
            while len(verdicts) < number:
                await ctx.tick()
            assert place_of(verdicts[-1]) == place_of(check_path(SMALL, terrain, path))

    simulate(dut, bench, background=[collect(dut.verdicts, verdicts)])
    assert [verdict.collision for verdict in verdicts] == [1, 1, 1, 0, 1, 0]


def test_waits_while_the_coarse_map_is_rebuilt():
    """No point or cell is taken between the last cell of a rectangle and the last block."""
    dut = shared(Checker, SMALL)
    waited = {}

    async def bench(ctx):
        await upload(ctx, dut, np.zeros((16, 16), dtype=int))
        while not ctx.get(dut.writes.ready):
            await ctx.tick()
        await upload(ctx, dut, [[5]], 3, 3)
        cycles = 0
        while not ctx.get(dut.writes.ready):
            assert not ctx.get(dut.points.ready)
            cycles += 1
            await ctx.tick()
        waited["cell"] = cycles
        assert ctx.get(dut.points.ready)

    simulate(dut, bench)
    assert waited["cell"] == SMALL.coarse_factor**2 + SMALL.lookup_latency + 2


def test_looks_up():
    """One cell per cycle, after ``lookup_latency``; an earlier coarse cell makes no difference."""
    terrain, paths = drawn(TINY, 5, 10)
    dut = shared(Checker, TINY)
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
    terrain, paths = drawn(TINY, 8, 40, peaks=0.2)
    results = results_of(
        Checker(TINY), terrain, paths, count=True, pauses=pauses, count_pauses=count_pauses
    )
    assert results.summaries == expected(TINY, terrain, paths, count=True)
    assert len(results.counts) > 40


def test_a_slow_source():
    """Gaps between the points do not change the verdicts."""
    terrain, paths = drawn(TINY, 9, 30)
    dut = shared(Checker, TINY)
    verdicts = []

    async def bench(ctx):
        await upload(ctx, dut, terrain.heights)
        for path in paths:
            for index, (x, y, altitude) in enumerate(path):
                for _ in range((x + y) % 4):
                    await ctx.tick()
                last = index == len(path) - 1
                await put(ctx, dut.points, {"x": x, "y": y, "altitude": altitude, "last": last})
        while ctx.get(dut.busy):
            await ctx.tick()

    simulate(dut, bench, background=[collect(dut.verdicts, verdicts)])
    assert [place_of(verdict) for verdict in verdicts] == [
        verdict[:6] for verdict in expected(TINY, terrain, paths)
    ]


pytestmark = pytest.mark.cosim

check = partial(check_verilated, model=defined)


@pytest.mark.ci
def test_every_segment_of_a_tiny_map():
    """All pairs of cells are tried as first, second and third segment: both tiers, all slopes."""
    config = TINY
    rng = np.random.default_rng(1)
    cells = list(itertools.product(range(config.map_size), repeat=2))
    with VerilatedChecker(config) as checker:
        terrain = ground(config, rng, peaks=0.1, blocked=0.03)
        checker.write(terrain.heights)
        for before in range(3):
            paths = []
            for start, stop in itertools.product(cells, repeat=2):
                z = rng.integers(4, 15, 2)
                paths.append([(*start, 15)] * before + [(*start, int(z[0])), (*stop, int(z[1]))])
            verdicts = check(checker, terrain, paths).verdicts
            assert 0.2 < np.mean([verdict["collision"] for verdict in verdicts]) < 0.9


@pytest.mark.parametrize(
    ("latency", "turns"),
    [
        pytest.param(1, 8, marks=pytest.mark.ci),
        pytest.param(1, 20, marks=pytest.mark.long),
        pytest.param(2, 20, marks=pytest.mark.long),
    ],
)
def test_queues_over_a_changing_map(latency, turns):
    """Queues, with or without counts and stalls, run between uploads that raise and lower cells."""
    config = Config(
        map_size=64, altitude_bits=8, checker="two-tier", lanes=1, memory_latency=latency
    )
    rng = np.random.default_rng(1)
    edge, top = config.map_size, config.blocked_altitude
    terrain = TerrainModel(config)
    with VerilatedChecker(config) as checker:
        terrain.write(0, 0, rng.integers(0, top // 4, (edge, edge)))
        checker.write(terrain.heights)
        for turn in range(turns):
            x, y = rng.integers(0, edge - 1, 2).tolist()
            width, height = rng.integers(1, 20, 2).tolist()
            altitudes = rng.integers(0, top // 4, (min(height, edge - y), min(width, edge - x)))
            if turn % 3:
                altitudes[rng.random(altitudes.shape) < 0.1 * (turn % 3)] = rng.integers(
                    top // 2, top
                )
                altitudes[rng.random(altitudes.shape) < 0.02] = top
            terrain.write(x, y, altitudes)
            checker.write(altitudes, x, y)
            paths = paths_of(random_batch(config, rng, 60))
            check(checker, terrain, paths)
            check(checker, terrain, paths, count=True)
            check(checker, terrain, paths, count=bool(turn % 2), stall=2 + turn)
            for path in paths[:5]:
                check(checker, terrain, [path], count=bool(turn % 2))
