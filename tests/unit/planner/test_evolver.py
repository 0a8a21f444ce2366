# amaranth: UnusedElaboratable=no
"""The evolver against the definition, generation by generation, evaluated by the definition."""

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from hdl.ga_core.random_source import RandomSource
from hdl.planner.evolver import Evolver
from hdl.protocol.planner import VALUE_BITS, PathClass
from hdl.protocol.runs import Island, RunOptions
from sim.model.planner.definition.breeder import Waypoint
from sim.model.planner.definition.evaluation import NO_LIMIT, Evaluator
from sim.model.planner.definition.memo import Memo
from sim.model.planner.definition.run import Run
from tests import planner_cases
from tests.planner_cases import SMALL, USUAL
from tests.planner_population import TINY, corner, waypoint
from tests.streams import simulate


_GIVEN_UP = PathClass.GIVEN_UP << VALUE_BITS


class WithSource(wiring.Component):
    """An evolver and the chip's random source."""

    def __init__(self, config, islands):
        self.evolver = Evolver(config, islands)
        super().__init__({"load": In(1), "seed": In(64)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.evolver = evolver = self.evolver
        m.submodules.source = source = RandomSource()
        m.d.comb += [
            source.load.eq(self.load),
            source.seed.eq(self.seed),
            evolver.words.payload.eq(source.words),
            evolver.words.valid.eq(source.ready),
            source.step.eq(evolver.words.valid & evolver.words.ready),
        ]
        return m


class Bench:
    """An evolver whose children the definition evaluates, and the definition's run beside it."""

    def __init__(self, config, seed, *, islands, stalled=False):
        self.config = config
        self.rng = rng = np.random.default_rng(seed)
        self.stalled = stalled
        self.seed = seed
        self.ground = planner_cases.ground(config, rng)
        self.record = planner_cases.record(config, rng)
        self.options = RunOptions(
            seed=seed,
            islands=(Island(False, 0),) * islands,
            give_up_rank=config.population // 4,
            memo=0,
        )
        self.run = Run(config, self.ground, self.record, self.options)
        self.evaluator = Evaluator(config, self.record, self.ground, Memo(config, 0))
        self.top = WithSource(config, islands)
        self.dut = self.top.evolver
        self.keys = []
        self.cycle = self.came = 0
        # Cycle of a generation's last key, and cycles from it to the next one's first point.
        self.latest = None
        self.gaps = []

    def pause(self, most):
        return int(self.rng.integers(most)) if self.stalled else 0

    async def start(self, ctx):
        """Load the seed and set what is steady."""
        dut, record = self.dut, self.record
        ctx.set(self.top.seed, self.seed)
        ctx.set(self.top.load, 1)
        ctx.set(dut.clear, 1)
        limits = record.x_limit, record.y_limit, record.altitude_limit
        ends = self.evaluator.ends
        for signal, point in ((dut.limits, limits), (dut.start, ends[0]), (dut.goal, ends[1])):
            ctx.set(signal, corner(point))
        ctx.set(dut.give_up_rank, self.options.give_up_rank)
        await ctx.tick()
        ctx.set(self.top.load, 0)
        ctx.set(dut.clear, 0)

    async def transfer(self, ctx, stream, payload):
        """Transfer a payload into the evolver, or one out of it if there is none to give."""
        gives = payload is not None
        for _ in range(self.pause(3)):
            await ctx.tick()
        if gives:
            ctx.set(stream.payload, payload)
        mine, other = (stream.valid, stream.ready) if gives else (stream.ready, stream.valid)
        ctx.set(mine, 1)
        for _ in range(20_000):
            _, _, there, word = await ctx.tick().sample(other, stream.payload)
            if there:
                ctx.set(mine, 0)
                return word
        raise TimeoutError(f"No transfer of {stream!r}")

    async def fill(self, ctx, island, count):
        """Make a first population of random paths; return it as the definition has it."""
        config, dut = self.config, self.dut
        ctx.set(dut.fills, 1)
        ctx.set(dut.island, island)
        members, waiting = [], []
        for number in range(count):
            slot = await self.transfer(ctx, dut.slots, None)
            length = int(self.rng.integers(2, config.max_waypoints + 1))
            # Some paths come twice, so that keys are equal.
            path = [waypoint(config, self.rng) for _ in range(length)]
            path = [each._replace(x=min(each.x, config.map_size - 2)) for each in path]
            path = [each._replace(y=min(each.y, config.map_size - 2)) for each in path]
            path = [each._replace(z=min(each.z, config.blocked_altitude - 1)) for each in path]
            if members and number % 3 == 0:
                path = members[-1].path
            member = self.run._evaluated(path, NO_LIMIT, first=False)
            for index, each in enumerate(member.path):
                ctx.set(dut.write, self.written(slot, index, each))
                await ctx.tick()
            ctx.set(dut.write.valid, 0)
            members.append(member)
            waiting.append((slot, member))
            while len(waiting) > self.pause(config.children):
                slot, member = waiting.pop(0)
                entry = {"key": member.key, "slot": slot, "length": len(member.path)}
                await self.transfer(ctx, dut.evaluated, entry)
        for slot, member in waiting:
            entry = {"key": member.key, "slot": slot, "length": len(member.path)}
            await self.transfer(ctx, dut.evaluated, entry)
        ctx.set(dut.store, 1)
        await ctx.tick()
        ctx.set(dut.store, 0)
        await self.wait(ctx, dut.busy, 0)
        ctx.set(dut.fills, 0)
        return sorted(members, key=lambda member: member.key)[: config.population]

    def written(self, slot, index, each):
        return {
            "valid": 1,
            "place": {"slot": slot, "index": index},
            "waypoint": {**corner(each[:3]), "margin": each.margin},
        }

    async def wait(self, ctx, signal, value):
        for _ in range(50_000):
            if ctx.get(signal) == value:
                return
            await ctx.tick()
        raise TimeoutError(f"{signal!r} does not become {value}")

    async def watch(self, ctx):
        """Note the cycles between the last child of a generation and the next point."""
        dut = self.dut
        sampled = dut.evaluated.valid & dut.evaluated.ready & ~dut.fills, dut.points.valid
        async for _, _, comes, offered in ctx.tick().sample(*sampled):
            self.came += comes
            if comes and self.came % self.config.children == 0:
                self.latest = self.cycle
            if offered and self.latest is not None:
                self.gaps.append(self.cycle - self.latest)
                self.latest = None
            self.cycle += 1

    async def evaluate(self, ctx):
        """Evaluate what is bred, with the keys that the evolver says."""
        dut = self.dut
        while True:
            child = await self.transfer(ctx, dut.children, None)
            points = []
            while not points or not points[-1].last:
                points.append(await self.transfer(ctx, dut.points, None))
            path = [(point.x, point.y, point.altitude) for point in points]
            assert len(path) == child.length + 2
            limit = ctx.get(dut.limit)
            limit = limit if limit < _GIVEN_UP else NO_LIMIT
            margins = [None] * len(path)
            first = ctx.get(dut.best) < _GIVEN_UP
            key = self.evaluator.evaluate(path, margins, limit, first=first)
            self.keys.append(key)
            for index, margin in enumerate(margins[1:-1]):
                if margin is not None:
                    place = {"slot": child.slot, "index": index}
                    await self.transfer(ctx, dut.margins, {"place": place, "margin": margin})
            await self.transfer(
                ctx, dut.evaluated, {"key": key, "slot": child.slot, "length": child.length}
            )

    async def command(self, ctx, pulse, island):
        """Give a command and wait for its end; return the cycles until the next may come."""
        ctx.set(self.dut.island, island)
        ctx.set(pulse, 1)
        await ctx.tick()
        ctx.set(pulse, 0)
        assert not ctx.get(self.dut.ready)
        await self.wait(ctx, self.dut.ready, 1)

    async def compare(self, ctx, island, population):
        """Compare the population of an island with the definition's."""
        dut = self.dut
        await self.wait(ctx, dut.busy, 0)
        ctx.set(dut.island, island)
        for rank, expected in enumerate(population):
            ctx.set(dut.rank, rank)
            await ctx.tick()
            member = ctx.get(dut.member)
            assert (member.key, member.length) == (expected.key, len(expected.path)), rank
            for index, each in enumerate(expected.path):
                ctx.set(dut.read, {"slot": member.slot, "index": index})
                await ctx.tick().repeat(2)
                held = ctx.get(dut.waypoint)
                assert Waypoint(held.x, held.y, held.altitude, held.margin) == each, (rank, index)

    def simulate(self, bench):
        simulate(self.top, bench, background=[self.evaluate, self.watch])


@pytest.mark.parametrize(
    ("config", "generations", "stalled"),
    [
        pytest.param(TINY, 16, False, id="tiny"),
        pytest.param(SMALL, 40, False, id="small"),
        pytest.param(SMALL, 6, True, id="small-stalled"),
        pytest.param(USUAL, 4, False, id="usual", marks=pytest.mark.ci),
    ],
)
def test_generations(config, generations, stalled):
    """Two islands in turn, then one population of the best of both."""
    bench = Bench(config, 7, islands=2, stalled=stalled)

    async def run(ctx):
        await bench.start(ctx)
        islands = [
            await bench.fill(ctx, island, config.population + 9 * (1 + island))
            for island in range(2)
        ]
        for island, population in enumerate(islands):
            await bench.compare(ctx, island, population)
        for generation in range(generations):
            island = generation // 2 % 2
            islands[island] = bench.run.breed(islands[island])
            await bench.command(ctx, bench.dut.begin, island)
            if generation % 3 == 0 or stalled:
                await bench.compare(ctx, island, islands[island])
        each = config.population // 2
        merged = sorted(islands[0][:each] + islands[1][:each], key=lambda member: member.key)
        ctx.set(bench.dut.merged, 1)
        await bench.command(ctx, bench.dut.merge, 0)
        await bench.compare(ctx, 0, merged)
        for _ in range(generations):
            merged = bench.run.breed(merged)
            await bench.command(ctx, bench.dut.begin, 0)
        await bench.compare(ctx, 0, merged)

    bench.simulate(run)
    if not stalled and config is not USUAL:
        assert min(bench.gaps) == 24 + bench.options.give_up_rank
    classes = {key >> VALUE_BITS for key in bench.keys}
    assert PathClass.INFEASIBLE in classes
    if config is SMALL and not stalled:
        assert classes == {PathClass.FEASIBLE, PathClass.GIVEN_UP, PathClass.INFEASIBLE}
