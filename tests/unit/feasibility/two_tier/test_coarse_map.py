"""The coarse map: maxima that rise and fall with rectangles, and the cycles this takes."""

import itertools
import random
from collections import deque

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.two_tier.coarse_map import CoarseMap
from pathgene.sim.model.checker import TerrainModel
from tests.support.gateware.streams import simulate


CONFIG = Config(checker="two-tier", lanes=1, map_size=16, coarse_factor=4, altitude_bits=4)


class Bench:
    """A coarse map, and a detailed one that answers after ``scan_latency`` cycles."""

    def __init__(self, config, scan_latency=3):
        self.config = config
        self.dut = CoarseMap(
            config.coordinate_bits,
            config.coarse_bits,
            config.altitude_bits,
            memory_latency=config.memory_latency,
            scan_latency=scan_latency,
        )
        self.terrain = TerrainModel(config)
        self.scans = 0

    async def answer(self, ctx):
        answers = deque([None] * self.dut.scan_latency)
        while True:
            dut = self.dut
            _, _, scanning, x, y = await ctx.tick().sample(dut.scanning, dut.scan_x, dut.scan_y)
            answers.append((x, y) if scanning else None)
            answers.popleft()
            self.scans += scanning
            # The answer to the oldest arrives in the cycle that begins now.
            cell = answers[0]
            ctx.set(dut.scanned, int(self.terrain.heights[cell[::-1]]) if cell else 5)

    async def write(self, ctx, x, y, rows):
        """Write a rectangle; return the cycles after its last cell in which the map is busy."""
        rows = np.asarray(rows)
        self.terrain.write(x, y, rows)
        cells = list(itertools.product(range(rows.shape[0]), range(rows.shape[1])))
        for number, (row, column) in enumerate(cells):
            assert not ctx.get(self.dut.busy)
            last = number == len(cells) - 1
            cell = {"x": x + column, "y": y + row, "altitude": int(rows[row, column]), "last": last}
            ctx.set(self.dut.writes.p, cell)
            ctx.set(self.dut.writes.valid, 1)
            assert ctx.get(self.dut.writes.ready & self.dut.written)
            await ctx.tick()
        # The next one would wait.
        ctx.set(self.dut.writes.p.last, 0)
        cycles = 0
        while ctx.get(self.dut.busy):
            assert not ctx.get(self.dut.writes.ready | self.dut.written)
            if cycles == 3:
                ctx.set(self.dut.writes.valid, 0)
            cycles += 1
            await ctx.tick()
        return cycles

    async def check(self, ctx):
        """Compare every block, one per cycle."""
        edge = 1 << self.config.coarse_bits
        blocks = list(itertools.product(range(edge), repeat=2))
        latency = self.config.memory_latency
        for cycle in range(len(blocks) + latency):
            if cycle >= latency:
                x, y = blocks[cycle - latency]
                assert ctx.get(self.dut.altitude) == self.terrain.coarse[y, x]
            if cycle < len(blocks):
                x, y = blocks[cycle]
                ctx.set(self.dut.x, x)
                ctx.set(self.dut.y, y)
            await ctx.tick()

    def run(self, function):
        async def testbench(ctx):
            edge = self.config.map_size
            await self.write(ctx, 0, 0, np.zeros((edge, edge), dtype=int))
            await function(ctx)

        simulate(self.dut, testbench, background=[self.answer])


@pytest.mark.parametrize("memory_latency", [1, 2])
@pytest.mark.parametrize("scan_latency", [1, 4])
def test_rises_and_falls(scan_latency, memory_latency):
    bench = Bench(CONFIG.replace(memory_latency=memory_latency), scan_latency)

    async def function(ctx):
        await bench.check(ctx)
        for x, y, cells in (
            (5, 6, [[9]]),  # Raises one block,
            (6, 6, [[7]]),  # does not lower it next to that cell,
            (5, 6, [[3]]),  # lowers it, but not to the new cell,
            (6, 6, [[0]]),  # and now to it.
            (2, 3, [[15, 1, 2], [1, 1, 8], [1, 1, 1]]),  # It covers the corner of four blocks.
            (2, 3, [[0, 0, 0], [0, 0, 0], [0, 0, 0]]),
        ):
            await bench.write(ctx, x, y, cells)
            await bench.check(ctx)
        assert bench.terrain.coarse.max() == 3

    bench.run(function)


def test_random_rectangles():
    rng = random.Random(20)
    bench = Bench(CONFIG.replace(map_size=8, coarse_factor=2))

    async def function(ctx):
        for _ in range(60):
            x, y = rng.randrange(8), rng.randrange(8)
            width, height = rng.randint(1, 8 - x), rng.randint(1, 8 - y)
            altitudes = [[rng.randrange(16) for _ in range(width)] for _ in range(height)]
            await bench.write(ctx, x, y, altitudes)
            await bench.check(ctx)

    bench.run(function)


@pytest.mark.parametrize("scan_latency", [1, 4])
def test_reads_touched_blocks_only(scan_latency):
    bench = Bench(CONFIG, scan_latency=scan_latency)

    async def function(ctx):
        for x, y, columns, rows, blocks in (
            (0, 0, 1, 1, 1),
            (3, 3, 2, 2, 4),
            (4, 8, 8, 1, 2),
            (15, 1, 1, 15, 4),
        ):
            bench.scans = 0
            cells = blocks * CONFIG.coarse_factor**2
            busy = await bench.write(ctx, x, y, np.ones((rows, columns), dtype=int))
            assert busy == cells + scan_latency + 2
            assert bench.scans == cells
            await bench.check(ctx)

    bench.run(function)
