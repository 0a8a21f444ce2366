"""The checking unit with a checker: its answers to the host equal the model's byte for byte."""

import random

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import connect

from pathgene.hdl.config import CheckerBuild
from pathgene.hdl.feasibility.check_controller import CheckController
from pathgene.hdl.feasibility.checker import Checker
from pathgene.hdl.protocol import (
    CheckFlag,
    check_paths_request,
    check_reply,
    pack_paths,
)
from pathgene.sim.model.check_commands import CheckingModel
from tests.support.gateware.chips import SMALL, random_path, random_paths
from tests.support.gateware.streams import collect, put, simulate


CONFIGS = {
    "two-tier": SMALL.replace(checker=CheckerBuild.TWO_TIER, lanes=1),
    "parallel": SMALL.replace(checker=CheckerBuild.PARALLEL, lanes=4),
}


class Chip(wiring.Component):
    """The unit with the checker that it serves."""

    def __init__(self, config):
        self.unit = CheckController(config)
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

        async def collect_records(ctx):
            await collect(ctx, self.chip.unit.records, self.records)

        simulate(self.chip, main, background=(read_out, collect_records))

    async def check(self, ctx, checks, points=None):
        """Return the totals and all results, as the host gets them, and the cycles elapsed."""
        unit = self.chip.unit
        ctx.set(unit.forget, 1)
        await ctx.tick()
        ctx.set(unit.forget, 0)
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


def test_configuration_is_checked():
    with pytest.raises(TypeError, match=r"^Config must be a Config, not 'big'$"):
        CheckController("big")
    rule = r"^Config\.checker must name a build, not 'none'$"
    with pytest.raises(ValueError, match=rule):
        CheckController(SMALL.replace(checker=CheckerBuild.NONE))
