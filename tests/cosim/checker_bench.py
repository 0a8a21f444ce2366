"""What the benches of the exported checker's builds share: the driver, and the tests themselves."""

import random

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge
from drivers import Stream

from hdl.feasibility.layouts import count_layout, verdict_layout
from hdl.layouts import cell_layout, point_layout
from sim.model.checker import TerrainModel, check_path
from sim.model.checker_cycles import batch_cycles


class Bench:
    """Drives the checker, and its model beside it."""

    def __init__(self, dut, config, seed, *, stalled=False):
        self.dut = dut
        self.config = config
        self.rng = random.Random(seed)
        self.terrain = TerrainModel(config)
        layouts = {
            "points": point_layout(config),
            "writes": cell_layout(config),
            "verdicts": verdict_layout(config),
            "counts": count_layout(config),
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
        top = self.config.blocked_altitude
        edge = self.config.map_size
        kinds = self.rng.choices((15, top - 1, top), weights=(100, 2, 1), k=edge * edge)
        cells = [kind if kind == top else self.rng.randint(0, kind) for kind in kinds]
        await self.write(0, 0, np.array(cells).reshape(edge, edge))

    def path(self):
        edge, top = self.config.map_size - 1, self.config.blocked_altitude
        length = self.rng.randint(2, self.config.max_waypoints + 2)
        return [
            (self.rng.randint(0, edge), self.rng.randint(0, edge), self.rng.randint(15, top))
            for _ in range(length)
        ]

    async def check(self, paths, *, count=False):
        """Queue ``paths`` and compare everything that comes; return the cycles and reads."""
        self.dut.count.value = int(count)
        points = [
            {"x": x, "y": y, "altitude": altitude, "last": number == len(path) - 1}
            for path in paths
            for number, (x, y, altitude) in enumerate(path)
        ]
        driver = cocotb.start_soon(self.points.put(*points))
        models = [check_path(self.config, self.terrain, path, count) for path in paths]
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


async def check_queues(dut, config, *, stalled, count):
    """Random paths, and rectangles that come and go between them."""
    bench = Bench(dut, config, seed=1 + count, stalled=stalled)
    await bench.reset()
    await bench.upload()
    for _ in range(4):
        await bench.check([bench.path() for _ in range(25)], count=count)
        x, y = (bench.rng.randrange(config.map_size - 4) for _ in "xy")
        altitude = bench.rng.choice((0, config.blocked_altitude))
        await bench.write(x, y, np.full((4, 3), altitude))


async def check_alone(dut, config):
    """Paths one by one: cycles and reads are the model's, and the flags those of the verdict."""
    bench = Bench(dut, config, seed=3)
    await bench.reset()
    await bench.upload()
    # The coarse map, where there is one, is up to date.
    await bench.check([bench.path()])
    for number in range(200):
        path, count = bench.path(), number % 2 == 1
        bench.dut.verdicts__ready.value = 1
        costs = await bench.check([path], count=count)
        assert costs == batch_cycles(config, bench.terrain, [path], count)
        hit = check_path(config, bench.terrain, path, count).collision
        assert (bool(dut.collision.value), bool(dut.clear.value)) == (hit, not hit)


async def check_reset(dut, config):
    """What was under way at a reset is gone; what is in the map stays."""
    bench = Bench(dut, config, seed=4)
    await bench.reset()
    await bench.upload()
    # A reset would leave a coarse map as far renewed as it is.
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
