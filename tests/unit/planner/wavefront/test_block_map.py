"""Blocks of the map: scans of all blocks and of marked ones, their cycles, the lowest corners."""

import random

import numpy as np
import pytest
from amaranth.hdl import Elaboratable, Module

from pathgene.hdl.planner.walker.segment_walker import SegmentWalker
from pathgene.hdl.planner.wavefront.block_map import BlockMap, LowestCorner
from pathgene.hdl.protocol.planner import BLOCKS, COARSE_BLOCKS
from pathgene.sim.model.planner.definition import wavefront
from pathgene.sim.model.planner.definition.score import corner_of
from pathgene.sim.model.planner.run_cycles import scanning
from tests.support.gateware.streams import put, shared, simulate
from tests.support.planner.cases import SMALL, upload
from tests.support.planner.wavefront import blocks_of, corner, problem, terrain


#: A map of 8 corners along each edge, less than blocks; and one of up to 2 in a block.
TINY = SMALL.replace(map_size=8)
TWICE = SMALL.replace(map_size=64)


class Bench:
    """A block map and the map that it reads."""

    def __init__(self, ctx, dut, ground):
        self.ctx, self.dut, self.ground = ctx, dut, ground
        self.asked = [(0, 0)] * dut.read_latency

    async def tick(self):
        ctx, dut = self.ctx, self.dut
        row = ctx.get(dut.row)
        self.asked.append((row.x, row.y))
        await ctx.tick()
        x, y = self.asked[-dut.read_latency]
        for lane, port in enumerate(dut.corners):
            ctx.set(port, int(self.ground[y, x * dut.lanes + lane]))

    def set_problem(self, record):
        self.ctx.set(self.dut.block_shift, record.block_shift)
        self.ctx.set(self.dut.fine, record.blocks == BLOCKS)
        for end in ("start", "goal"):
            self.ctx.set(getattr(self.dut, end), corner(*corner_of(record, end)))

    async def write(self, x, y, altitude):
        self.ground[y, x] = altitude
        self.ctx.set(self.dut.write, {"valid": 1, "x": x, "y": y})
        await self.tick()
        self.ctx.set(self.dut.write, {"valid": 0, "x": 0, "y": 0})

    async def scan(self):
        """Scan, and return the cycles."""
        self.ctx.set(self.dut.launch, 1)
        await self.tick()
        self.ctx.set(self.dut.launch, 0)
        cycles = 0
        while self.ctx.get(self.dut.busy):
            await self.tick()
            cycles += 1
        return cycles

    async def check(self, config, record, blocks_of=blocks_of):
        """Compare all blocks within the map with the definition's."""
        blocks = blocks_of(config, record, self.ground)
        place = self.ctx.get(self.dut.start_block), self.ctx.get(self.dut.goal_block)
        assert [(each.x, each.y) for each in place] == [blocks.start, blocks.goal]
        places = [(x, y) for y in range(blocks.edge) for x in range(blocks.edge)]
        for number in range(len(places) + 2):
            x, y = places[number % len(places)]
            self.ctx.set(self.dut.number, y * BLOCKS + x)
            if number >= 2:
                x, y = places[number - 2]
                each = self.ctx.get(self.dut.block)
                assert each.free == ((x, y) in blocks.least)
                if each.free:
                    assert each.altitude == blocks.least[x, y]
                if max(x, y) < config.map_size:
                    assert (each.x, each.y) == blocks.lowest[x, y]
            await self.tick()


@pytest.mark.parametrize(("config", "lanes", "latency"), [(TINY, 2, 1), (SMALL, 8, 4)])
def test_single_corners(config, lanes, latency):
    """Each block is a single corner; blocks beyond a small map are blocked."""
    rng = np.random.default_rng(lanes)
    dut = shared(BlockMap, lanes, config.coordinate_bits, config.altitude_bits, latency)

    async def bench(ctx):
        own = Bench(ctx, dut, terrain(config, rng, blocked=0.2))
        for marked in (COARSE_BLOCKS**2, 0):
            record = problem(config, rng)
            own.set_problem(record)
            assert await own.scan() == scanning(COARSE_BLOCKS, marked, 0, lanes, latency)
            await own.check(config, record)

    simulate(dut, bench)


def test_marks_and_shifts():
    """Corners are written, blocked or not, also beyond the blocks; then the block size changes."""
    rng = np.random.default_rng(3)
    config, lanes = TWICE, 4
    dut = shared(BlockMap, lanes, config.coordinate_bits, config.altitude_bits, 2)
    top = config.blocked_altitude

    async def bench(ctx):
        own = Bench(ctx, dut, terrain(config, rng, blocked=0.05))
        wide, narrow, fine = (
            problem(config, rng, shift=shift, fine=fine)
            for shift, fine in ((1, False), (0, False), (0, True))
        )
        own.set_problem(wide)
        assert await own.scan() == scanning(32, 32**2, 1, lanes, 2)
        await own.check(config, wide)

        # The write just before a scan is seen, too.
        writes = [(63, 63, 0), (0, 0, top), (1, 0, 3), (62, 63, top), (20, 41, 1)]
        for write in writes:
            await own.write(*write)
        assert await own.scan() == scanning(32, 3, 1, lanes, 2)
        await own.check(config, wide)
        assert await own.scan() == scanning(32, 0, 1, lanes, 2)

        # Marks of one size have no meaning for a different size.
        own.set_problem(narrow)
        await own.write(40, 3, 1)
        await own.write(9, 30, 2)
        own.set_problem(wide)
        assert await own.scan() == scanning(32, 32**2, 1, lanes, 2)
        await own.check(config, wide)
        own.set_problem(narrow)
        assert await own.scan() == scanning(32, 32**2, 0, lanes, 2)
        for write in [(32, 0, 5), (0, 32, 5), (31, 7, top)]:
            await own.write(*write)
        assert await own.scan() == scanning(32, 1, 0, lanes, 2)
        await own.check(config, narrow)

        # Nor have they for another number of blocks of this size.
        own.set_problem(fine)
        assert await own.scan() == scanning(64, 64**2, 0, lanes, 2)
        await own.check(config, fine)
        for write in [(32, 0, 5), (0, 63, 5), (31, 7, 1)]:
            await own.write(*write)
        assert await own.scan() == scanning(64, 3, 0, lanes, 2)
        await own.check(config, fine)
        own.set_problem(narrow)
        assert await own.scan() == scanning(32, 32**2, 0, lanes, 2)

    simulate(dut, bench)


class MapAndBlocks(Elaboratable):
    """A walker, and a block map that reads its map."""

    def __init__(self, config):
        sizes = config.coordinate_bits, config.altitude_bits
        self.walker = SegmentWalker(config.lanes, *sizes, 1, config.memory_latency)
        self.blocks = BlockMap(config.lanes, *sizes, self.walker.row_latency)

    def elaborate(self, platform):
        m = Module()
        m.submodules.walker, m.submodules.blocks = walker, blocks = self.walker, self.blocks
        m.d.comb += [
            walker.row.eq(blocks.row),
            *(into.eq(corner) for into, corner in zip(blocks.corners, walker.corners, strict=True)),
            blocks.write.valid.eq(walker.writes.valid),
            blocks.write.x.eq(walker.writes.p.x),
            blocks.write.y.eq(walker.writes.p.y),
        ]
        return m


class WalkerBench(Bench):
    """A block map that reads the map of a walker by itself."""

    async def tick(self):
        await self.ctx.tick()


@pytest.mark.ci
@pytest.mark.parametrize(
    ("config", "lanes", "latency"), [(SMALL, 1, 2), (TWICE, 4, 1), (SMALL, 8, 2)]
)
def test_map_of_a_walker(config, lanes, latency):
    """A random map is written, then some corners; both are scanned from the walker's map."""
    rng = np.random.default_rng(lanes)
    config = config.replace(lanes=lanes, memory_latency=latency)
    dut = shared(MapAndBlocks, config)
    shift = config.coordinate_bits - SMALL.coordinate_bits
    record = problem(config, rng, shift=shift, fine=False)
    changed = rng.integers(config.map_size, size=(20, 2)).tolist()

    def defined(config, record, ground):
        return wavefront.blocks_of(record, ground, config.blocked_altitude)

    async def bench(ctx):
        own = WalkerBench(ctx, dut.blocks, terrain(config, rng, blocked=0.1))
        own.set_problem(record)
        await upload(ctx, dut.walker, own.ground)
        for marked in (record.blocks**2, len({(x >> shift, y >> shift) for x, y in changed})):
            cycles = scanning(record.blocks, marked, shift, lanes, dut.blocks.read_latency)
            assert await own.scan() == cycles
            await own.check(config, record, defined)
            for x, y in changed:
                own.ground[y, x] = rng.integers(config.blocked_altitude + 1)
                cell = {**corner(x, y, int(own.ground[y, x])), "last": 0}
                await put(ctx, dut.walker.writes, cell)

    simulate(dut, bench)


def test_lanes_are_within_the_map():
    with pytest.raises(ValueError, match=r"^Lanes must be a power of two from 1 to 4, not 8$"):
        BlockMap(8, 2, 4, 1)


@pytest.mark.parametrize("lanes", [1, 2, 8])
def test_random_rows(lanes):
    rng, dut = random.Random(lanes), LowestCorner(lanes, 3)
    rows = [([rng.randrange(8) for _ in range(lanes)], rng.getrandbits(lanes)) for _ in range(500)]
    found = []

    async def bench(ctx):
        for cycle in range(len(rows) + dut.latency):
            corners, counts = rows[min(cycle, len(rows) - 1)]
            for port, value in zip(dut.corners, corners, strict=True):
                ctx.set(port, value)
            ctx.set(dut.counts, counts)
            if cycle >= dut.latency:
                found.append(ctx.get(dut.lowest))
            await ctx.tick()

    simulate(dut, bench)
    for (corners, counts), lowest in zip(rows, found, strict=True):
        counted = [(corner, lane) for lane, corner in enumerate(corners) if counts >> lane & 1]
        assert lowest.none == (not counted)
        assert lowest.blocked == any(corner == 7 for corner, _ in counted)
        if counted:
            assert (lowest.altitude, lowest.lane) == min(counted)
