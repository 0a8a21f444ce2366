"""The controller of checks, and the order and pace of its points."""

import random

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import connect

from pathgene.hdl.config import CheckerBuild
from pathgene.hdl.feasibility.check_controller import CheckController, PathSource
from pathgene.hdl.feasibility.checker import Checker
from pathgene.hdl.ga_core.core import PaperCore
from pathgene.hdl.protocol.codes import CheckFlag
from pathgene.hdl.protocol.messages import check_paths_request, check_reply
from pathgene.hdl.protocol.paths import pack_paths
from pathgene.sim.model.check_commands import CheckingModel
from tests.support.gateware.chips import SMALL, TINY, random_path, random_paths
from tests.support.gateware.streams import collect, pulse, put, shared, simulate


CONFIG = TINY.replace(population=16, children=8, survivors=6, max_waypoints=5, checker="parallel")
START, GOAL = 0x5A3, 0xC0F


class PathChip(wiring.Component):
    """The source with the population that it reads."""

    def __init__(self):
        self.core = PaperCore(CONFIG)
        self.source = PathSource(
            CONFIG.coordinate_bits, CONFIG.altitude_bits, CONFIG.max_waypoints, CONFIG.population
        )
        super().__init__({})

    def elaborate(self, platform):
        m = Module()
        m.submodules.core = self.core
        m.submodules.source = self.source
        connect(m, self.source.reads, self.core.reads)
        connect(m, self.core.waypoints, self.source.waypoints)
        return m


def words(path):
    """A path as ``x``, ``y``, ``altitude`` and ``last`` of each of its points."""
    return [
        (word & 15, word >> 4 & 15, word >> 8, at == len(path) - 1) for at, word in enumerate(path)
    ]


def offered(paths, orders, *, busy=lambda cycle: False, limit=4000):
    """Load ``paths``, carry out ``orders``, and return the points of each with their cycles.

    An order is a slot and a count, or the points of one path, or such points with None: they are
    given, but not checked. The result of each order has the points, the cycle of each point since
    the source was turned on, and the cycles after the first point in which a point was requested
    but none was available.
    """
    chip = PathChip()
    source = chip.source
    outcomes = []

    async def bench(ctx):
        for slot, path in enumerate(paths):
            for index, waypoint in enumerate(path):
                last = index == len(path) - 1
                word = {"slot": slot, "index": index, "waypoint": waypoint, "last": last}
                await put(ctx, chip.core.writes, word)
        for first, second in orders:
            if not isinstance(first, int):
                await pulse(ctx, source.forget)
                for x, y, altitude, last in words(first):
                    point = {"x": x, "y": y, "altitude": altitude, "last": last}
                    await put(ctx, source.points, point, limit=1)
                if second is None:
                    continue
                checks, ends = {"batch": 0}, 1
            else:
                checks = {"batch": 1, "slot": first, "count": second, "start": START, "goal": GOAL}
                ends = second
            outcomes.append(await one(ctx, checks, ends))

    async def one(ctx, checks, ends):
        points, cycles, missed = [], [], 0
        ctx.set(source.checks, checks)
        ctx.set(source.on, 1)
        for cycle in range(limit):
            ready = not busy(cycle)
            ctx.set(source.paths.ready, ready)
            _, _, valid, point = await ctx.tick().sample(source.paths.valid, source.paths.payload)
            if valid and ready:
                points.append((point.x, point.y, point.altitude, point.last))
                cycles.append(cycle)
                ends -= point.last
            missed += ready and not valid and bool(points) and ends > 0
            if ends == 0:
                break
        assert ends == 0
        ctx.set(source.paths.ready, 1)
        for _ in range(10):  # Nothing comes after the last goal.
            _, _, valid = await ctx.tick().sample(source.paths.valid)
            assert not valid
        ctx.set(source.on, 0)
        await ctx.tick().repeat(3)
        return points, cycles, missed

    simulate(chip, bench)
    return outcomes


def batch_of(paths):
    return [point for path in paths for point in words([START, *path, GOAL])]


def paths_of(length, seed=1):
    rng = random.Random(seed)
    return [random_path(CONFIG, rng, length) for _ in range(CONFIG.population)]


@pytest.mark.ci
@pytest.mark.parametrize("length", [2, None])
def test_a_point_in_every_clock(length):
    """The shortest paths are no exception, nor are points that the checker stalled."""
    paths = paths_of(length)
    late = random.Random(2)
    stop = set(late.sample(range(60), 20)) | set(range(70, 140))
    steady = offered(paths, [(0, 16), (3, 1), (15, 1), (4, 9)])
    held = offered(paths, [(0, 16)], busy=lambda cycle: cycle in stop)
    asked = [(0, 16), (3, 1), (15, 1), (4, 9), (0, 16)]
    for (slot, count), (points, cycles, missed) in zip(asked, steady + held, strict=True):
        assert points == batch_of(paths[slot : slot + count])
        assert missed == 0
        assert cycles[0] <= 13 + count * 5 / 4


@pytest.mark.ci
def test_one_path():
    orders = [(path, "check") for path in paths_of(None)]
    for (path, _), (points, cycles, missed) in zip(orders, offered([], orders), strict=True):
        assert points == words(path)
        assert missed == 0
        assert cycles == list(range(4, 4 + len(path)))


def test_points_that_are_not_checked_are_forgotten():
    """A command that is refused after some of its points leaves such points."""
    paths = paths_of(3)
    orders = []
    for number in range(20):
        orders += [([1] * (number % 6 + 2), None), (paths[number % 16], "check"), (number % 16, 1)]
    outcomes = [points for points, _, _ in offered(paths, orders)]
    assert outcomes[::2] == [words(paths[number % 16]) for number in range(20)]
    assert outcomes[1::2] == [batch_of([paths[number % 16]]) for number in range(20)]


def test_the_longest_path_fits():
    path = list(range(CONFIG.max_waypoints + 2))
    [(points, _, _)] = offered([], [(path, "check")])
    assert points == words(path)


def test_a_read_waits_until_it_is_taken():
    """Only one read waits, however late the population is ready for it."""
    source = PathSource(4, 4, 5, 16)

    async def bench(ctx):
        ctx.set(source.checks, {"batch": 1, "slot": 3, "count": 2, "start": START, "goal": GOAL})
        ctx.set(source.on, 1)
        await ctx.tick().until(source.reads.valid)
        for _ in range(5):
            assert ctx.get(source.reads.valid)
            assert ctx.get(source.reads.p) == {"slot": 3, "count": 2}
            await ctx.tick()
        ctx.set(source.reads.ready, 1)
        await ctx.tick()
        for _ in range(5):
            assert not ctx.get(source.reads.valid)
            await ctx.tick()

    simulate(source, bench)


@pytest.mark.parametrize(
    ("max_waypoints", "population", "depth"), [(5, 16, 32), (5, None, 8), (62, None, 64)]
)
def test_depth_of_the_buffer(max_waypoints, population, depth):
    """The buffer has room for one path, and for twice as many points as paths in a batch."""
    assert PathSource(4, 4, max_waypoints, population).depth == depth


CONFIGS = {
    "two-tier": SMALL.replace(checker=CheckerBuild.TWO_TIER, lanes=1),
    "parallel": SMALL.replace(checker=CheckerBuild.PARALLEL, lanes=4),
}


class Chip(wiring.Component):
    """The unit with the checker that it serves."""

    def __init__(self, config):
        self.unit = shared(CheckController, config)
        self.checker = Checker(config)
        super().__init__({})

    def elaborate(self, platform):
        m = Module()
        m.submodules.unit = unit = self.unit
        m.submodules.checker = checker = self.checker
        connect(m, unit.paths, checker.points)
        connect(m, checker.verdicts, unit.verdicts)
        connect(m, checker.counts, unit.counts)
        m.d.comb += checker.count.eq(unit.counting)
        return m


class Bench:
    """Drives the unit like its neighbouring units."""

    def __init__(self, config, heights, paths):
        self.config = config
        self.chip = Chip(config)
        self.paths = paths
        self.records = []
        self._heights = heights

    def run(self, bench):
        async def main(ctx):
            for y, row in enumerate(self._heights):
                for x, altitude in enumerate(row):
                    last = (x, y) == (len(row) - 1, len(self._heights) - 1)
                    cell = {"x": x, "y": y, "altitude": int(altitude), "last": last}
                    await put(ctx, self.chip.checker.writes, cell)
            await bench(ctx)

        async def read_out(ctx):
            """Like the population: one waypoint per cycle, with 3 cycles between paths."""
            unit = self.chip.unit
            while True:
                ctx.set(unit.reads.ready, 1)
                _, _, valid, read = await ctx.tick().sample(unit.reads.valid, unit.reads.payload)
                ctx.set(unit.reads.ready, 0)
                if not valid:
                    continue
                for slot in range(read.slot, read.slot + read.count):
                    await ctx.tick().repeat(3)
                    for at, waypoint in enumerate(self.paths[slot]):
                        last = at == len(self.paths[slot]) - 1
                        final = last and slot == read.slot + read.count - 1
                        word = {"waypoint": waypoint, "last": last, "final": final}
                        await put(ctx, unit.waypoints, word)

        simulate(
            self.chip, main, background=(read_out, collect(self.chip.unit.records, self.records))
        )

    async def check(self, ctx, checks, points=None):
        """Return the totals and all results, as the host gets them, and the cycles elapsed."""
        unit = self.chip.unit
        await pulse(ctx, unit.forget)
        for at, word in enumerate(points or ()):
            shift = self.config.coordinate_bits
            point = {
                "x": word & (1 << shift) - 1,
                "y": word >> shift & (1 << shift) - 1,
                "altitude": word >> 2 * shift,
                "last": at == len(points) - 1,
            }
            await put(ctx, unit.points, point, limit=1)
        ctx.set(unit.checks, checks)
        ctx.set(unit.on, 1)
        elapsed = 0
        done = 0
        while not done:
            _, _, done = await ctx.tick().sample(unit.done)
            elapsed += 1
            assert elapsed < 20_000
        ctx.set(unit.on, 0)
        await ctx.tick().repeat(3)
        totals = ctx.get(unit.totals)
        named = {name: totals[name] for name, _ in totals.shape()}
        self.records.clear()
        read = {"path": 0, "count": ctx.get(unit.checked)}
        await put(ctx, unit.result_reads, read, limit=1)
        while not (self.records and self.records[-1].last):
            await ctx.tick()
        body = bytes(record.data for record in self.records)
        return check_reply(self.config).pack(**named) + body, elapsed


@pytest.mark.parametrize("build", CONFIGS)
@pytest.mark.parametrize("flags", [CheckFlag(0), CheckFlag.COUNT], ids=["stopping", "counting"])
def test_answers_are_those_of_the_model(build, flags):
    config = CONFIGS[build]
    rng = random.Random(6)
    edge = config.map_size
    ground = np.random.default_rng(6)
    heights = ground.choice((0, 1, 2, 9, 15), (edge, edge), p=(0.5, 0.3, 0.16, 0.03, 0.01))
    paths = random_paths(config, rng)
    model = CheckingModel(config)
    model.terrain.write(0, 0, heights)
    bench = Bench(config, heights, paths)
    counting = bool(flags)

    async def compare(ctx):
        for length in (2, 7, 3, 5):
            path = random_path(config, rng, length)
            told, elapsed = await bench.check(ctx, {"batch": 0, "counting": counting}, path)
            expected = model.check(bytes((flags,)) + pack_paths(config, [path]), False)
            assert told == expected, (path, told.hex(), expected.hex())
        for slot, count in ((0, 8), (2, 1), (5, 3), (0, 8)):
            start, goal = random_path(config, rng, 2)
            asked = {"slot": slot, "count": count, "start": start, "goal": goal}
            checks = {"batch": 1, "counting": counting, **asked}
            told, elapsed = await bench.check(ctx, checks)
            request = check_paths_request(config).pack(**asked, flags=flags)
            expected = model.check_paths(paths, request, False)
            assert told == expected, (asked, told.hex(), expected.hex())
            # In addition to the checker's own cycles, a few to get ahead and to finish.
            cycles = check_reply(config).unpack(told[: check_reply(config).size])["cycles"]
            assert cycles < elapsed <= cycles + 16 + count * 5 / 4
        counters = ctx.get(bench.chip.unit.counters)
        assert {counter.value: counters[counter] for counter in model.counters} == model.counters

    bench.run(compare)
