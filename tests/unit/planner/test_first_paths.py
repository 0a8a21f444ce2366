"""First paths: their points and writes equal the definition's, and their cycles."""

import itertools
import random

import numpy as np
import pytest

from pathgene.hdl.planner.first_paths import FirstPathKind, FirstPaths
from pathgene.sim.model.planner.definition.score import corner_of
from pathgene.sim.model.planner.run_cycles import (
    MEMBER,
    SEED,
    WAYPOINT,
    member_offered,
    seed_offered,
    seeded,
)
from pathgene.sim.model.planner.seeds import ahead
from tests.support.gateware.streams import simulate
from tests.support.planner import cases as planner_cases
from tests.support.planner.cases import LARGE, SMALL, USUAL
from tests.support.planner.population import corner, population


class Bench:
    """Environment of the unit: paths by slot, ranks, a source of seeds, and receivers."""

    def __init__(self, config, seed, share):
        self.config = config
        self.rng, self.pauses, self.share = np.random.default_rng(seed), random.Random(seed), share
        self.slots = 2 * config.population + 3
        self.dut = FirstPaths(
            self.slots,
            config.population,
            config.max_waypoints,
            config.coordinate_bits,
            config.altitude_bits,
        )
        middle = config.map_size << 7
        self.record = planner_cases.record(config, self.rng, start_x=middle, start_y=middle)
        paths = population(config, self.rng)
        order = self.rng.permutation(self.slots).tolist()
        self.ranks = order[: len(paths)]
        self.free = order[len(paths) :]
        self.memory = {slot: list(path) for slot, path in zip(self.ranks, paths, strict=True)}
        self.lengths = {slot: len(path) for slot, path in self.memory.items()}
        self.ends = [corner_of(self.record, end) for end in ("start", "goal")]
        # Events with their cycles.
        self.cycle = 0
        self.taken, self.written, self.begun = [], [], []
        self.offers, self.goals = [], []

    def seeds(self, count):
        """Return random seeds, the shortest and the longest often."""
        config = self.config
        longest = config.max_waypoints
        paths = []
        for _ in range(count):
            length = int(self.rng.choice([2, longest, self.rng.integers(2, longest + 1)]))
            bits = [config.coordinate_bits] * 2 + [config.altitude_bits]
            paths.append(
                [tuple(int(self.rng.integers(1 << each)) for each in bits) for _ in range(length)]
            )
        return paths

    async def run(self, ctx, kind, count, seeds=()):
        """Make the paths; return the cycle of the launch."""
        dut = self.dut
        ctx.set(dut.frame.start, corner(self.ends[0]))
        ctx.set(dut.frame.goal, corner(self.ends[1]))
        ctx.set(dut.frame.limits.altitude, self.record.altitude_limit)
        ctx.set(dut.kind, kind)
        ctx.set(dut.count, count)
        ctx.set(dut.launch, 1)
        launched = self.cycle
        reads, asked, coming = [None] * 2, 0, {}
        seeds, seed_free, is_new = list(seeds), 0, True
        while True:
            ctx.set(dut.seed_busy, self.cycle < seed_free)
            ctx.set(dut.seed, coming.pop(self.cycle, {"valid": 0}))
            ctx.set(dut.free_slots.valid, bool(self.free) and self._moves())
            ctx.set(dut.free_slots.payload, self.free[0] if self.free else 0)
            ctx.set(dut.paths.ready, self._moves())
            # The scorer takes points in slots of two cycles.
            ctx.set(dut.points.ready, self.cycle % 2 == 0 and self._moves())
            if ctx.get(dut.begin_seed):
                assert self.cycle >= seed_free
                path = seeds.pop(0)
                seed_free = self.cycle + seeded(len(path)) + 1
                for i, point in enumerate(path):
                    found = {"valid": 1, "last": i == len(path) - 1, **corner(point)}
                    coming[self.cycle + 2 + i + WAYPOINT] = found
            if ctx.get(dut.free_slots.valid & dut.free_slots.ready):
                self.free.pop(0)
            if ctx.get(dut.paths.valid & dut.paths.ready):
                self.taken.append((ctx.get(dut.paths.payload), []))
            if ctx.get(dut.points.valid) and is_new:
                self.offers.append(self.cycle)
                is_new = False
            if ctx.get(dut.points.valid & dut.points.ready):
                point = ctx.get(dut.points.payload)
                self.taken[-1][1].append((point.x, point.y, point.altitude))
                is_new = bool(point.last)
                if is_new:
                    self.goals.append(self.cycle)
            elif not is_new and self.share == 1:
                # Only the parity of the cycle delays a point.
                assert ctx.get(dut.points.valid)
            write = ctx.get(dut.write)
            if write.valid:
                point = write.waypoint
                slot, index = write.place.slot, write.place.index
                self.written.append((slot, index, (point.x, point.y, point.altitude)))
                if slot in self.memory:
                    path = self.memory[slot]
                    path[index] = path[index]._replace(x=point.x, y=point.y, z=point.altitude)
            rank, read = ctx.get(dut.rank), ctx.get(dut.read)
            reads.append((read.slot, read.index))
            await ctx.tick()
            self.cycle += 1
            ctx.set(dut.launch, 0)
            member = self.ranks[rank]
            ctx.set(dut.member, {"slot": member, "length": self.lengths[member], "key": 0})
            slot, index = reads[-2] or (0, 0)
            path = self.memory.get(slot, ())
            if index < len(path):
                each = path[index]
                ctx.set(dut.waypoint, {**corner(each[:3]), "margin": each.margin})
            if not ctx.get(dut.busy):
                # The last write is in a register.
                assert not ctx.get(dut.write.valid)
                assert not seeds
                return launched
            asked += 1
            assert asked < 40_000

    def _moves(self):
        return self.share == 1 or self.pauses.random() < self.share

    def expected(self, paths):
        start, goal = self.ends
        return [[start, *path, goal] for path in paths]

    def check_writes(self, slots, paths):
        assert self.written == [
            (slot, index, point)
            for slot, path in zip(slots, paths, strict=True)
            for index, point in enumerate(path)
        ]


SHARES = pytest.mark.parametrize("share", [1, 0.4], ids=["steady", "stalled"])
CONFIGS = pytest.mark.parametrize("config", [SMALL, USUAL, LARGE], ids=["small", "usual", "large"])


@SHARES
@CONFIGS
def test_seeds(config, share):
    bench = Bench(config, 3, share)
    count = config.population + 2
    seeds, free = bench.seeds(count), list(bench.free)

    async def run(ctx):
        launched = await bench.run(ctx, FirstPathKind.SEED, count, seeds)
        assert [path for _, path in bench.taken] == bench.expected(seeds)
        assert [slot for slot, _ in bench.taken] == free[:count]
        bench.check_writes(free, [*seeds, *[[]] * (len(free) - count)])
        if share == 1:
            frees = [launched, *bench.goals[:-1]]
            assert bench.offers == [seed_offered(each) for each in frees]
            assert bench.offers[0] == launched + SEED

    simulate(bench.dut, run)


@pytest.mark.ci
@SHARES
@CONFIGS
def test_lifted_members(config, share):
    bench = Bench(config, 4, share)
    limit = bench.record.altitude_limit
    lifted = [
        [(x, y, min(z + max(-margin, 0), limit)) for x, y, z, margin in bench.memory[slot]]
        for slot in bench.ranks
    ]

    async def run(ctx):
        launched = await bench.run(ctx, FirstPathKind.LIFTED, config.population)
        assert bench.taken == list(zip(bench.ranks, bench.expected(lifted), strict=True))
        bench.check_writes(bench.ranks, lifted)
        if share == 1:
            frees = [launched, *bench.goals[:-1]]
            assert bench.offers == [member_offered(each, 0) for each in frees]
            assert bench.offers[0] == launched + MEMBER

    simulate(bench.dut, run)


@SHARES
@CONFIGS
def test_revived_members(config, share):
    bench = Bench(config, 5, share)
    # Waypoints on the line through the start across the route are beyond it.
    start = bench.ends[0]
    for path in itertools.islice(bench.memory.values(), 3):
        path[0] = path[0]._replace(x=start[0], y=start[1])
    paths = [[each[:3] for each in bench.memory[slot]] for slot in bench.ranks]
    left = [ahead(config, bench.record, path) for path in paths]
    dropped = [len(path) - len(rest) for path, rest in zip(paths, left, strict=True)]
    assert min(dropped) == 0
    assert max(dropped) > 1

    async def run(ctx):
        launched = await bench.run(ctx, FirstPathKind.REVIVED, config.population)
        assert bench.taken == list(zip(bench.ranks, bench.expected(left), strict=True))
        bench.check_writes(bench.ranks, left)
        if share == 1:
            frees = [launched, *bench.goals[:-1]]
            assert bench.offers == list(map(member_offered, frees, dropped))

    simulate(bench.dut, run)
