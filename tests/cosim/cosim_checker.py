"""The exported checker on a map of 64 x 64: queues, stalls and resets.

``CHECKER`` in the environment names the build.
"""

import os
import random

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge
from drivers import Stream

from pathgene.hdl.feasibility.layouts import count_layout, verdict_layout
from pathgene.hdl.layouts import cell_layout, point_layout
from pathgene.sim.model.checker import TerrainModel, check_path
from pathgene.sim.model.checker_cycles import batch_cycles
from tests.support.gateware.chips import CHECKER_BENCH


TOP = "path_checker"
CONFIG = CHECKER_BENCH[os.environ.get("CHECKER", "parallel")]


class Bench:
    """Driver of the checker and its model."""

    def __init__(self, dut, seed, *, stalled=False):
        self.dut = dut
        self.rng = random.Random(seed)
        self.terrain = TerrainModel(CONFIG)
        layouts = {
            "points": point_layout(CONFIG.coordinate_bits, CONFIG.altitude_bits),
            "writes": cell_layout(CONFIG.coordinate_bits, CONFIG.altitude_bits),
            "verdicts": verdict_layout(
                CONFIG.coordinate_bits, CONFIG.segment_bits, CONFIG.path_cells_bits
            ),
            "counts": count_layout(CONFIG.coordinate_bits, CONFIG.segment_bits),
        }
        for name, layout in layouts.items():
            stream = Stream(dut, name, layout, dut.clk)
            stream.idle(driven=name in ("points", "writes"))
            if stalled:
                stream.pauses = lambda: self.rng.choice((0, 0, 0, 2, 30))
            setattr(self, name, stream)
        for name in ("count", "lookup_valid", "lookup_x", "lookup_y"):
            getattr(dut, name).value = 0

    async def reset(self):
        self.dut.rst.value = 1
        Clock(self.dut.clk, 10, unit="ns").start()
        await FallingEdge(self.dut.clk)
        self.dut.rst.value = 0

    async def write(self, x, y, block):
        self.terrain.write(x, y, block)
        cells = [
            {"x": x + column, "y": y + row, "altitude": int(altitude), "last": 0}
            for row, altitudes in enumerate(block)
            for column, altitude in enumerate(altitudes)
        ]
        cells[-1]["last"] = 1
        await self.writes.put(*cells)

    async def upload(self):
        """Write rough ground with some peaks and blocked cells."""
        top = CONFIG.blocked_altitude
        edge = CONFIG.map_size
        kinds = self.rng.choices((15, top - 1, top), weights=(100, 2, 1), k=edge * edge)
        cells = [kind if kind == top else self.rng.randint(0, kind) for kind in kinds]
        await self.write(0, 0, np.array(cells).reshape(edge, edge))

    def path(self):
        edge, top = CONFIG.map_size - 1, CONFIG.blocked_altitude
        length = self.rng.randint(2, CONFIG.max_waypoints + 2)
        return [
            (self.rng.randint(0, edge), self.rng.randint(0, edge), self.rng.randint(15, top))
            for _ in range(length)
        ]

    async def check(self, paths, *, count=False):
        """Queue ``paths`` and compare verdicts and counts; return the cycles and reads."""
        self.dut.count.value = int(count)
        points = [
            {"x": x, "y": y, "altitude": altitude, "last": number == len(path) - 1}
            for path in paths
            for number, (x, y, altitude) in enumerate(path)
        ]
        driver = cocotb.start_soon(self.points.put(*points))
        models = [check_path(CONFIG, self.terrain, path, count) for path in paths]
        counting = cocotb.start_soon(self._counts(sum(len(model.entries) for model in models)))
        costs = []
        for model in models:
            verdict = await self.verdicts.get()
            got = (bool(verdict.collision), verdict.segment, verdict.x, verdict.y, verdict.cells)
            assert got == (model.collision, model.segment, model.x, model.y, model.cells)
            assert verdict.entries == len(model.entries)
            costs.append((verdict.cycles, verdict.reads))
        await driver
        assert await counting == [entry for model in models for entry in model.entries]
        assert not self.dut.busy.value
        return costs

    async def _counts(self, number):
        counts = [await self.counts.get() for _ in range(number)]
        return [(count.segment, count.terrain, count.nofly) for count in counts]


@cocotb.test()
@cocotb.parametrize(stalled=[False, True], count=[False, True])
async def queues(dut, stalled, count):
    """Check random paths in queues, and change rectangles of the map between them."""
    bench = Bench(dut, seed=1 + count, stalled=stalled)
    await bench.reset()
    await bench.upload()
    for _ in range(4):
        await bench.check([bench.path() for _ in range(25)], count=count)
        x, y = (bench.rng.randrange(CONFIG.map_size - 4) for _ in "xy")
        altitude = bench.rng.choice((0, CONFIG.blocked_altitude))
        await bench.write(x, y, np.full((4, 3), altitude))


@cocotb.test()
async def alone(dut):
    """Check single paths: cycles and reads equal the model's, and the flags follow the verdict."""
    bench = Bench(dut, seed=3)
    await bench.reset()
    await bench.upload()
    # Afterwards the coarse map, if any, is up to date.
    await bench.check([bench.path()])
    for number in range(200):
        path, count = bench.path(), number % 2 == 1
        bench.dut.verdicts__ready.value = 1
        costs = await bench.check([path], count=count)
        assert costs == batch_cycles(CONFIG, bench.terrain, [path], count)
        hit = check_path(CONFIG, bench.terrain, path, count).collision
        assert (bool(dut.collision.value), bool(dut.clear.value)) == (hit, not hit)


@cocotb.test()
async def reset_during_a_check(dut):
    """Discard a check at a reset, and keep the map."""
    bench = Bench(dut, seed=4)
    await bench.reset()
    await bench.upload()
    # Afterwards the coarse map is up to date; an earlier reset would leave it partly rebuilt.
    await bench.check([bench.path()])
    for cycles in (3, 9, 20):
        driver = cocotb.start_soon(bench.points.put(*({"x": 31, "last": i == 7} for i in range(8))))
        for _ in range(cycles):
            await FallingEdge(dut.clk)
        driver.cancel()
        bench.points.idle(driven=True)
        dut.rst.value = 1
        await FallingEdge(dut.clk)
        dut.rst.value = 0
        await bench.check([bench.path() for _ in range(5)])
